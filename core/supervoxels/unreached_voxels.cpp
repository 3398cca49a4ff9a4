#include "core/supervoxels/unreached_voxels.hpp"

#include "core/base/stop_check.hpp"

namespace segserve::growth {

Filling::Filling(const VoxelAdjacency& adjacency, const Distance& distance, StopCheck& check, State& state)
    : adjacency_(adjacency), distance_(distance), check_(check), state_(state) {
  state_.rest.clear();
  check_.for_each(0, state_.voxels.size(), [&](std::size_t v) {
    if (state_.voxels[v].owner == kNobody) state_.rest.push_back(static_cast<std::uint32_t>(v));
  });
}

/// What touches a cluster in one layer and did not before touches a voxel of the layer before: no need to go through
/// the whole rest each time.
void Filling::reach_the_rest() {
  trim_rest();
  state_.layer.clear();
  ++state_.turn;
  check_.for_each(0, state_.rest.size(), [&](std::size_t i) { return 1 + claim_for_nearest(state_.rest[i]); });
  std::size_t begin = 0;
  while (begin < state_.layer.size() && !check_.stopped()) {
    const std::size_t end = state_.layer.size();
    check_.for_each(begin, end,
                    [&](std::size_t i) { state_.voxels[state_.layer[i].voxel].owner = state_.layer[i].cluster; });
    check_.for_each(begin, end, [&](std::size_t i) {
      std::size_t work = 1;
      for (const std::uint32_t u : adjacency_.of(state_.layer[i].voxel)) work += 1 + claim_for_nearest(u);
      return work;
    });
    begin = end;
  }
}

void Filling::adopt_components() {
  for (const std::uint32_t first : state_.rest) {
    if (check_.after(1)) return;
    if (state_.voxels[first].owner != kNobody) continue;
    const std::uint32_t c = state_.new_cluster();
    state_.layer.assign(1, {first, c});
    state_.voxels[first].owner = c;
    for (std::size_t i = 0; i < state_.layer.size(); ++i) {
      const auto neighbors = adjacency_.of(state_.layer[i].voxel);
      if (check_.after(1 + neighbors.size())) return;
      for (const std::uint32_t u : neighbors) {
        if (state_.voxels[u].owner != kNobody) continue;
        state_.voxels[u].owner = c;
        state_.layer.push_back({u, c});
      }
    }
  }
}

/// Voxel v, if it is free, is claimed for the nearest cluster that touches it, but once. Returns the work.
std::size_t Filling::claim_for_nearest(std::uint32_t v) {
  if (state_.voxels[v].owner != kNobody || state_.voxels[v].seen == state_.turn) return 0;
  const auto neighbors = adjacency_.of(v);
  std::uint32_t nearest = kNobody;
  float smallest = kUnreached;
  for (const std::uint32_t u : neighbors) {
    const std::uint32_t c = state_.voxels[u].owner;
    if (c == kNobody) continue;
    const float d = distance_between(distance_, state_.clusters[c].centre, state_.voxels[v].feature);
    if (d < smallest || (d == smallest && c < nearest)) smallest = d, nearest = c;
  }
  if (nearest != kNobody) {
    state_.voxels[v].seen = state_.turn;
    state_.layer.push_back({v, nearest});
  }
  return neighbors.size();
}

/// Leaves only voxels without owner in the rest.
void Filling::trim_rest() {
  std::size_t kept = 0;
  const bool complete = check_.for_each(0, state_.rest.size(), [&](std::size_t i) {
    if (state_.voxels[state_.rest[i]].owner == kNobody) state_.rest[kept++] = state_.rest[i];
  });
  if (complete) state_.rest.resize(kept);
}

}  // namespace segserve::growth
