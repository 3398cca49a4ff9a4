// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "segserve/cloud.hpp"
#include "segserve/codec/warning.hpp"

namespace segserve::codec {

/// The content of a PCD or PLY file: a cloud of N points, and the labels if the file has some.
struct LabeledCloud {
  Cloud cloud;
  std::vector<std::uint32_t> label;  ///< N: the label of each point; empty if the file has no labels
  std::string view_rule;             ///< one line for people that tells which view was chosen, and why
  std::vector<Warning> warnings;     ///< what of the file was not used
};

}  // namespace segserve::codec
