// SPDX-License-Identifier: Apache-2.0
#include "core/voxels/seam.hpp"

#include <algorithm>
#include <cstdint>
#include <vector>

#include "core/base/stop_check.hpp"
#include "core/voxels/voxel_key.hpp"
#include "core/voxels/voxel_links.hpp"

namespace segserve {

absl::Status join_seam(const FrameContext& frame, const VoxelGrid& grid, VoxelAdjacency& adjacency) {
  if (!frame.scale.sweep) return absl::OkStatus();
  constexpr VoxelKey kColumnMask = (VoxelKey{1} << kCellBits) - 1;
  const std::int32_t columns = columns_of_turn(frame.scale);
  const auto first = static_cast<VoxelKey>(kCellBias - columns / 2);
  const auto turn = static_cast<VoxelKey>(columns - 1);
  StopCheck check(frame.stop);
  std::vector<VoxelLink> links;
  check.for_each(0, grid.size(), [&](std::size_t v) {
    if ((grid.key[v] & kColumnMask) != first) return;
    for (std::int64_t dz = -1; dz <= 1; ++dz) {
      for (std::int64_t dy = -1; dy <= 1; ++dy) {
        const auto step =
            static_cast<VoxelKey>((dz * (std::int64_t{1} << kCellBits) + dy) * (std::int64_t{1} << kCellBits));
        const VoxelKey other = grid.key[v] + turn + step;
        const auto found = std::ranges::lower_bound(grid.key, other);
        if (found == grid.key.end() || *found != other) continue;
        links.push_back({static_cast<std::uint32_t>(v), static_cast<std::uint32_t>(found - grid.key.begin())});
      }
    }
  });
  if (!links.empty() && !check.stopped()) add_links(links, check, adjacency);
  return check.status();
}

}  // namespace segserve
