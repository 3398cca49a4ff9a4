#include "core/supervoxels/growth.hpp"

#include <algorithm>

#include "core/base/stop_check.hpp"
#include "core/supervoxels/growth_iterations.hpp"
#include "core/supervoxels/unreached_voxels.hpp"

namespace segserve {
namespace {

using growth::State;

/// Positions, colours and normals scaled by the weights; nothing has an owner.
void read_voxels(const VoxelGrid& grid, const VoxelAdjacency& adjacency, const std::vector<Vec3>& normals,
                 const SupervoxelOptions& options, const StopToken& stop, State& state) {
  const double position_scale = options.spatial_weight / options.seed_resolution;
  state.clear(grid.size());
  StopCheck(stop).for_each(0, grid.size(), [&](std::size_t v) {
    const Vec3 position = position_scale * grid.centroid[v];
    const Vec3 color = (options.color_weight / 255 / grid.points[v]) * grid.color_sum[v];
    const std::uint32_t first = adjacency.offset[v], neighbors = adjacency.offset[v + 1] - first;
    state.most_neighbors = std::max<std::size_t>(state.most_neighbors, neighbors);
    state.voxels[v] = {
        growth::feature(position, color, normals[v]), growth::kUnreached, growth::kNobody, 0, first, neighbors};
  });
}

void number_in_order(State& state, const StopToken& stop, Supervoxels& result) {
  result.count = 0;
  result.of_voxel.resize(state.voxels.size());
  state.number.assign(state.cluster_count, growth::kNobody);
  StopCheck(stop).for_each(0, state.voxels.size(), [&](std::size_t v) {
    std::uint32_t& n = state.number[state.voxels[v].owner];
    if (n == growth::kNobody) n = result.count++;
    result.of_voxel[v] = n;
  });
}

}  // namespace

GrowthScratch::GrowthScratch() : state_(std::make_unique<State>()) {}
GrowthScratch::GrowthScratch(GrowthScratch&&) noexcept = default;
GrowthScratch& GrowthScratch::operator=(GrowthScratch&&) noexcept = default;
GrowthScratch::~GrowthScratch() = default;

absl::Status grow_supervoxels(const VoxelGrid& grid, const VoxelAdjacency& adjacency, const std::vector<Vec3>& normals,
                              const Seeds& seeds, const SupervoxelOptions& options, const StopToken& stop,
                              GrowthScratch& scratch, Supervoxels& supervoxels) {
  const auto most_rounds = static_cast<int>(1.8 * options.seed_resolution / options.voxel_resolution + 1e-6) - 1;
  const growth::Distance distance{static_cast<float>(options.normal_weight), options.color_weight > 0};
  State& state = scratch.state();
  read_voxels(grid, adjacency, normals, options, stop, state);
  if (absl::Status status = stop.check(); !status.ok()) return status;
  StopCheck check(stop);
  growth::Rounds rounds(adjacency, distance, check, state);
  rounds.plant(seeds.chosen);
  rounds.first();
  for (int round = 1; round < most_rounds; ++round) {
    if (absl::Status status = stop.check(); !status.ok()) return status;
    if (!rounds.next()) break;
  }
  growth::Filling filling(adjacency, distance, check, state);
  filling.reach_the_rest();
  rounds.plant(seeds.sparse);
  filling.reach_the_rest();
  filling.adopt_components();
  if (absl::Status status = stop.check(); !status.ok()) return status;
  number_in_order(state, stop, supervoxels);
  return stop.check();
}

}  // namespace segserve
