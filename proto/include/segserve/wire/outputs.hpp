// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

namespace segserve::wire {

/// How arrays travel.
enum class Compression : std::uint8_t {
  kNone,  ///< as they are
  kZstd,  ///< as a Zstandard frame where that is smaller
};

/// Which arrays an answer holds besides its summary.
struct Outputs {
  bool labels = true;                            ///< the segment of every point
  bool supervoxels = false;                      ///< the supervoxel of every point
  bool tree = false;                             ///< the merge tree
  bool segments = false;                         ///< statistics of every segment: Segmentation::statistics
  Compression compression = Compression::kNone;  ///< that the arrays may have
  bool operator==(const Outputs&) const = default;
};

}  // namespace segserve::wire
