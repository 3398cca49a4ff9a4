// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <vector>

#include "core/base/stop_check.hpp"
#include "core/supervoxels/growth_state.hpp"
#include "core/voxels/voxel_adjacency.hpp"

namespace segserve::growth {

/// Lets clusters grow from their seeds. In an iteration each cluster, in the order of the seeds, takes the neighboring
/// voxels that are nearer to its center than to that of their own cluster; then the centers move.
///
/// All methods leave off when `check` stops them.
class GrowthIterations {
 public:
  GrowthIterations(const VoxelAdjacency& adjacency, const DistanceWeights& weights, StopCheck& check,
                   GrowthState& state)
      : adjacency_(adjacency), weights_(weights), check_(check), state_(state) {}

  /// Makes a cluster of each seed that has none yet.
  void seed(const std::vector<std::uint32_t>& seeds);

  /// The first iteration, in which clusters take all neighbors that no earlier cluster took. In PCL the distances of
  /// the first iteration do not count either, because all centers are still at the origin. A seed next to an earlier
  /// one goes to the cluster of that, and its own has no voxels left. This thins out the seeds.
  void run_first();

  /// Another iteration. Returns whether it changed anything.
  bool run_next();

 private:
  std::uint32_t prefetch_after(std::uint32_t c);
  template <typename AssignCandidates>
  void expand(std::uint32_t c, AssignCandidates&& assign_candidates);
  template <typename AssignCandidates>
  std::size_t split_candidates(const Expansion& expansion, AssignCandidates&& assign_candidates);
  std::size_t drop_separated(const Expansion& expansion, std::size_t count);
  void assign(std::uint32_t c, std::size_t count);
  void add_candidates(const Expansion& expansion, std::size_t count);
  bool update_centers();

  const VoxelAdjacency& adjacency_;
  DistanceWeights weights_;
  StopCheck& check_;
  GrowthState& state_;
  const GrowthKernels& kernels_ = growth_kernels();
};

}  // namespace segserve::growth
