#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include "absl/status/status.h"
#include "core/math/vec3.hpp"
#include "core/supervoxels/seeds.hpp"
#include "core/voxels/voxel_adjacency.hpp"
#include "core/voxels/voxel_grid.hpp"
#include "segserve/options.hpp"
#include "segserve/stop_token.hpp"

namespace segserve {

/// A partition of the voxels. Supervoxels are numbered from 0 in the order of their smallest voxels.
struct Supervoxels {
  std::vector<std::uint32_t> of_voxel;  ///< V
  std::uint32_t count = 0;              ///< m
};

namespace growth {
struct State;
}

/// Buffers of `grow_supervoxels` that are worth keeping between calls.
class GrowthScratch {
 public:
  GrowthScratch();
  GrowthScratch(GrowthScratch&&) noexcept;
  GrowthScratch& operator=(GrowthScratch&&) noexcept;
  ~GrowthScratch();
  growth::State& state() { return *state_; }

 private:
  std::unique_ptr<growth::State> state_;
};

/// Grows supervoxels from the seeds (VCCS, Papon et al. 2013): in rounds, each takes the neighbouring
/// voxels that are nearer to it than to their present owner by
///     color |dRGB| / 255 + spatial |dx| / seed resolution + normal (1 - |n . n'|),
/// then moves its centre. After 1.8 seed/voxel resolutions of rounds, as in PCL, voxels not reached
/// yet are given to the nearest neighbouring supervoxel; components without a seed get one. So every
/// voxel has exactly one supervoxel.
/// CANCELLED, DEADLINE_EXCEEDED.
absl::Status grow_supervoxels(const VoxelGrid& grid, const VoxelAdjacency& adjacency, const std::vector<Vec3>& normals,
                              const Seeds& seeds, const SupervoxelOptions& options, const StopToken& stop,
                              GrowthScratch& scratch, Supervoxels& supervoxels);

}  // namespace segserve
