// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include "absl/status/status.h"
#include "core/base/frame_context.hpp"
#include "core/math/vec3.hpp"
#include "core/supervoxels/seed_selection.hpp"
#include "core/voxels/voxel_adjacency.hpp"
#include "core/voxels/voxel_grid.hpp"

namespace segserve {

/// A partition of the voxels. Supervoxels are numbered from 0 in the order of their smallest voxels.
struct Supervoxels {
  std::vector<std::uint32_t> supervoxel_of_voxel;  ///< V: below m
  std::uint32_t count = 0;                         ///< m
};

namespace growth {
struct GrowthState;
}

/// Grows supervoxels from seeds (VCCS, Papon et al. 2013). In each iteration every supervoxel takes the neighboring
/// voxels that are nearer to its center than to that of their own supervoxel, by the distance
///
///     color_weight |dRGB| / 255 + spatial_weight |dx| / seed_resolution + normal_weight (1 - |n . n'|),
///
/// and then moves its center to the mean of its voxels. As in PCL, there are 1.8 seed_resolution / voxel_resolution
/// iterations. Voxels that are not reached by then are assigned to the nearest neighboring supervoxel, and components
/// without a seed become supervoxels of their own. So every voxel is in exactly one supervoxel.
class SupervoxelGrowth {
 public:
  SupervoxelGrowth();
  SupervoxelGrowth(SupervoxelGrowth&&) noexcept;
  SupervoxelGrowth& operator=(SupervoxelGrowth&&) noexcept;
  ~SupervoxelGrowth();

  /// `normals` has a unit vector, or 0, for each voxel. CANCELLED, DEADLINE_EXCEEDED.
  absl::Status run(const FrameContext& frame, const VoxelGrid& grid, const std::vector<Vec3>& positions,
                   const VoxelAdjacency& adjacency, const std::vector<Vec3>& normals, const Seeds& seeds,
                   Supervoxels& supervoxels);

 private:
  std::unique_ptr<growth::GrowthState> state_;
};

}  // namespace segserve
