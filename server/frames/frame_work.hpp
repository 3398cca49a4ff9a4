// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>
#include <cstdint>
#include <optional>

#include "segserve/segment.hpp"

namespace segserve::server {

/// The findings of a frame's computation, and their times. A time is unset if the computation did not get so far.
struct FrameWork {
  using Time = std::chrono::steady_clock::time_point;

  std::optional<Time> started;    ///< decoding began
  std::optional<Time> decoded;    ///< decoding ended, and segmentation began
  std::optional<Time> segmented;  ///< segmentation ended, and encoding began
  std::optional<Time> encoded;    ///< the result was encoded

  std::uint64_t points = 0;         ///< of the cloud, finite or not; known from `decoded` on
  std::uint64_t decoded_bytes = 0;  ///< of coordinates and colors; known from `decoded` on
  std::uint64_t voxels = 0;         ///< known from `segmented` on, as are the numbers below
  std::uint32_t supervoxels = 0, segments = 0;
  StageTimings stages;  ///< ms; the stages follow each other between `decoded` and `segmented`
};

}  // namespace segserve::server
