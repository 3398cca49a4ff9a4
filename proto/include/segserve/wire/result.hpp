// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>

#include "segserve/cloud.hpp"
#include "segserve/options.hpp"
#include "segserve/segment.hpp"

namespace segserve::wire {

/// Wall times outside the segmentation, milliseconds (v1.Timings says from when to when).
struct CallTimings {
  double queue = 0;
  double decode = 0;
  double encode = 0;
  double total = 0;
};

/// A result as both ends of the wire know it.
struct Result {
  /// Arrays that were not asked for are empty. On the client `timings.total` is the sum of its stages.
  Segmentation segmentation;
  std::size_t points = 0;
  std::uint32_t supervoxels = 0;
  Method method = Method::kBorder;
  std::optional<std::uint32_t> regions;  ///< the number that was asked for; unset if the cut is at a threshold
  View view;                             ///< the view that was used
  std::string view_rule;                 ///< why this view, for people
  CallTimings timings;
  std::string server_version;    ///< of the program that segmented
  std::string options_hash;      ///< 16 hexadecimal digits over all options that decide results
  bool in_this_process = false;  ///< on the client: computed here, not by a server
};

}  // namespace segserve::wire
