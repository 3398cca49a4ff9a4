// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

namespace segserve::wire {

/// How the arrays of an answer may be compressed. The segment statistics are never compressed.
enum class Compression : std::uint8_t {
  kNone,  ///< not at all
  kZstd,  ///< each array as a Zstandard frame, if that makes it smaller
};

/// The arrays of an answer besides its summary. N is the number of points.
struct Outputs {
  bool labels = true;                            ///< the segment of each point: Segmentation::labels, N values
  bool supervoxels = false;                      ///< the supervoxel of each point: Segmentation::supervoxels, N values
  bool tree = false;                             ///< the merge tree: Segmentation::tree
  bool segments = false;                         ///< the statistics of the segments: Segmentation::statistics
  Compression compression = Compression::kNone;  ///< which compression the server may use
  bool operator==(const Outputs&) const = default;
};

}  // namespace segserve::wire
