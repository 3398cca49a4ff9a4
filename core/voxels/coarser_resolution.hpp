// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>

#include "core/base/frame_context.hpp"

namespace segserve {

/// A voxel resolution, meters, at which the points that the options select fill at most `voxels` (at least 1) voxels:
/// the resolution of the frame times a power of two. The number of voxels at such a resolution is estimated by linear
/// counting (K.-Y. Whang, B. T. Vander-Zanden, H. M. Taylor, 1990) with a margin of 5 %. O(N) for each power, 1 MiB of
/// memory. Once the frame is stopped, the result means nothing.
double coarser_resolution(const FrameContext& frame, std::size_t voxels);

}  // namespace segserve
