// SPDX-License-Identifier: Apache-2.0
#include "core/supervoxels/supervoxel_growth.hpp"

#include <algorithm>

#include "core/base/stop_check.hpp"
#include "core/supervoxels/growth_iterations.hpp"
#include "core/supervoxels/unreached_voxels.hpp"

namespace segserve {
namespace {

using growth::GrowthState;

/// Fills `state` with voxels that are in no cluster.
void read_voxels(const FrameContext& frame, const VoxelGrid& grid, const std::vector<Vec3>& positions,
                 const VoxelAdjacency& adjacency, const std::vector<Vec3>& normals, StopCheck& check,
                 GrowthState& state) {
  const double position_scale = frame.settings.spatial_weight / frame.scale.seed;
  const double color_scale = frame.settings.color_weight / 255;
  state.clear(grid.size());
  check.for_each(0, grid.size(), [&](std::size_t v) {
    const Vec3 position = position_scale * positions[v];
    const Vec3 color = (color_scale / grid.points[v]) * grid.color_sum[v];
    const std::uint32_t first = adjacency.offset[v], neighbors = adjacency.offset[v + 1] - first;
    state.most_neighbors = std::max<std::size_t>(state.most_neighbors, neighbors);
    state.voxels[v] = {
        growth::make_feature(position, color, normals[v]), growth::kUnreached, growth::kNoCluster, 0, first, neighbors};
  });
}

/// Iterations of growth, the first one included.
int most_iterations(const VoxelScale& scale) { return static_cast<int>(1.8 * scale.seed / scale.voxel + 1e-6) - 1; }

void number_supervoxels(StopCheck& check, GrowthState& state, Supervoxels& supervoxels) {
  supervoxels.count = 0;
  supervoxels.supervoxel_of_voxel.resize(state.voxels.size());
  state.supervoxel_of_cluster.assign(state.cluster_count, growth::kNoCluster);
  check.for_each(0, state.voxels.size(), [&](std::size_t v) {
    std::uint32_t& supervoxel = state.supervoxel_of_cluster[state.voxels[v].cluster];
    if (supervoxel == growth::kNoCluster) supervoxel = supervoxels.count++;
    supervoxels.supervoxel_of_voxel[v] = supervoxel;
  });
}

}  // namespace

SupervoxelGrowth::SupervoxelGrowth() : state_(std::make_unique<GrowthState>()) {}
SupervoxelGrowth::SupervoxelGrowth(SupervoxelGrowth&&) noexcept = default;
SupervoxelGrowth& SupervoxelGrowth::operator=(SupervoxelGrowth&&) noexcept = default;
SupervoxelGrowth::~SupervoxelGrowth() = default;

absl::Status SupervoxelGrowth::run(const FrameContext& frame, const VoxelGrid& grid, const std::vector<Vec3>& positions,
                                   const VoxelAdjacency& adjacency, const std::vector<Vec3>& normals,
                                   const Seeds& seeds, Supervoxels& supervoxels) {
  StopCheck check(frame.stop);
  read_voxels(frame, grid, positions, adjacency, normals, check, *state_);
  const growth::DistanceWeights weights{static_cast<float>(frame.settings.normal_weight),
                                        frame.settings.color_weight > 0};
  growth::GrowthIterations iterations(adjacency, weights, check, *state_);
  iterations.seed(seeds.chosen);
  iterations.run_first();
  const int most = most_iterations(frame.scale);
  for (int iteration = 1; iteration < most; ++iteration) {
    if (!iterations.run_next()) break;
  }
  growth::UnreachedVoxelAssigner unreached(adjacency, weights, check, *state_);
  unreached.assign_by_layers();
  iterations.seed(seeds.sparse);
  unreached.assign_by_layers();
  unreached.make_clusters_of_components();
  if (!check.stopped()) number_supervoxels(check, *state_, supervoxels);
  return check.status();
}

}  // namespace segserve
