// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "segserve/cloud.hpp"

namespace segserve::codec {

/// What a file holds that is of use to us.
struct LabelledCloud {
  Cloud cloud;
  std::vector<std::uint32_t> label;  ///< one per point; empty if the file has none
  std::string view_rule;             ///< one line for people: which view was chosen, and why
};

}  // namespace segserve::codec
