#pragma once

#include <algorithm>
#include <cstddef>

#include "core/base/parallel.hpp"
#include "core/base/stop_check.hpp"
#include "core/voxels/voxel_adjacency.hpp"
#include "segserve/stop_token.hpp"

namespace segserve {

/// work(first, last) for blocks of the voxels of each thread's range; voxels and their neighbours count as work. For
/// kernels, which do not look at the token themselves.
template <typename Work>
void for_voxel_blocks(const VoxelAdjacency& adjacency, unsigned threads, const StopToken& stop, Work&& work) {
  constexpr std::size_t kBlock = 32;
  parallel_ranges(adjacency.offset.size() - 1, threads, [&](std::size_t begin, std::size_t end) {
    StopCheck check(stop, threads);
    for (std::size_t first = begin; first < end; first += kBlock) {
      const std::size_t last = std::min(first + kBlock, end);
      if (check.after(last - first + adjacency.offset[last] - adjacency.offset[first])) return;
      work(first, last);
    }
  });
}

}  // namespace segserve
