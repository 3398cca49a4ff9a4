// SPDX-License-Identifier: Apache-2.0
#include "core/supervoxels/unreached_voxels.hpp"

namespace segserve::growth {

UnreachedVoxelAssigner::UnreachedVoxelAssigner(const VoxelAdjacency& adjacency, const DistanceWeights& weights,
                                               StopCheck& check, GrowthState& state)
    : adjacency_(adjacency), weights_(weights), check_(check), state_(state) {
  state_.unreached.clear();
  check_.for_each(0, state_.voxels.size(), [&](std::size_t v) {
    if (state_.voxels[v].cluster == kNoCluster) state_.unreached.push_back(static_cast<std::uint32_t>(v));
  });
}

/// Only the first layer is searched for among all unreached voxels: a voxel of any other layer has a neighbor in the
/// layer before.
void UnreachedVoxelAssigner::assign_by_layers() {
  drop_reached();
  state_.layers.clear();
  ++state_.expansion_count;
  check_.for_each(0, state_.unreached.size(), [&](std::size_t i) { return 1 + add_to_layer(state_.unreached[i]); });
  std::size_t begin = 0;
  while (begin < state_.layers.size() && !check_.stopped()) {
    const std::size_t end = state_.layers.size();
    check_.for_each(begin, end, [&](std::size_t i) {
      const LayerVoxel& assigned = state_.layers[i];
      state_.voxels[assigned.voxel].cluster = assigned.cluster;
    });
    check_.for_each(begin, end, [&](std::size_t i) {
      std::size_t work = 1;
      for (const std::uint32_t u : adjacency_.of(state_.layers[i].voxel)) work += 1 + add_to_layer(u);
      return work;
    });
    begin = end;
  }
}

void UnreachedVoxelAssigner::make_clusters_of_components() {
  for (const std::uint32_t first : state_.unreached) {
    if (check_.after(1)) return;
    if (state_.voxels[first].cluster != kNoCluster) continue;
    const std::uint32_t c = state_.add_cluster();
    state_.layers.assign(1, {first, c});
    state_.voxels[first].cluster = c;
    for (std::size_t i = 0; i < state_.layers.size(); ++i) {
      const auto neighbors = adjacency_.of(state_.layers[i].voxel);
      if (check_.after(1 + neighbors.size())) return;
      for (const std::uint32_t u : neighbors) {
        if (state_.voxels[u].cluster != kNoCluster) continue;
        state_.voxels[u].cluster = c;
        state_.layers.push_back({u, c});
      }
    }
  }
}

/// Adds voxel v to the next layer if it is unreached, has a neighbor in a cluster, and is in no layer yet. Returns the
/// number of neighbors that were looked at.
std::size_t UnreachedVoxelAssigner::add_to_layer(std::uint32_t v) {
  Voxel& voxel = state_.voxels[v];
  if (voxel.cluster != kNoCluster || voxel.visited_in == state_.expansion_count) return 0;
  const auto neighbors = adjacency_.of(v);
  std::uint32_t nearest = kNoCluster;
  float smallest = kUnreached;
  for (const std::uint32_t u : neighbors) {
    const std::uint32_t c = state_.voxels[u].cluster;
    if (c == kNoCluster) continue;
    const float distance = distance_between(weights_, state_.clusters[c].center, voxel.feature);
    if (distance < smallest || (distance == smallest && c < nearest)) smallest = distance, nearest = c;
  }
  if (nearest != kNoCluster) {
    voxel.visited_in = state_.expansion_count;
    state_.layers.push_back({v, nearest});
  }
  return neighbors.size();
}

/// Removes the voxels that have a cluster by now from the unreached ones.
void UnreachedVoxelAssigner::drop_reached() {
  std::size_t kept = 0;
  const bool complete = check_.for_each(0, state_.unreached.size(), [&](std::size_t i) {
    const std::uint32_t v = state_.unreached[i];
    if (state_.voxels[v].cluster == kNoCluster) state_.unreached[kept++] = v;
  });
  if (complete) state_.unreached.resize(kept);
}

}  // namespace segserve::growth
