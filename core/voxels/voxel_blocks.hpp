// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cstddef>

#include "absl/status/status.h"
#include "core/base/frame_context.hpp"
#include "core/base/parallel_parts.hpp"
#include "core/base/stop_check.hpp"
#include "core/voxels/voxel_adjacency.hpp"

namespace segserve {

/// Calls work(first, last) for small blocks of voxels, on the threads of the frame. Looks at the stop token between the
/// blocks, which the kernels do not do themselves; voxels and their neighbors count as work. CANCELLED,
/// DEADLINE_EXCEEDED.
template <typename Work>
absl::Status for_voxel_blocks(const FrameContext& frame, const VoxelAdjacency& adjacency, Work&& work) {
  constexpr std::size_t kBlock = 32;
  return parallel_parts(frame.executor, frame.stop, adjacency.offset.size() - 1,
                        [&](unsigned, std::size_t begin, std::size_t end, StopCheck& check) {
                          for (std::size_t first = begin; first < end; first += kBlock) {
                            const std::size_t last = std::min(first + kBlock, end);
                            if (check.after(last - first + adjacency.offset[last] - adjacency.offset[first])) return;
                            work(first, last);
                          }
                        });
}

}  // namespace segserve
