// SPDX-License-Identifier: Apache-2.0
#include "core/supervoxels/growth_iterations.hpp"

#include <algorithm>
#include <limits>

namespace segserve::growth {
namespace {

constexpr std::size_t kBlock = 256;  // candidates, or assigned voxels, between two calls of StopCheck

/// Larger than any distance that is measured, but less than kUnreached.
constexpr float kNotMeasured = std::numeric_limits<float>::max();

/// Takes the place of the kernel assign_candidates in the first iteration.
std::size_t assign_unreached(const Expansion& expansion, const std::uint32_t* candidates, std::size_t count,
                             AssignedVoxel* assigned, std::uint32_t* kept) {
  std::size_t assigned_count = 0, kept_count = 0;
  for (std::size_t i = 0; i < count; ++i) {
    const std::uint32_t u = candidates[i];
    const bool unreached = expansion.voxels[u].distance == kUnreached;
    expansion.voxels[u].visited_in = expansion.number;
    assigned[assigned_count] = {u, kNotMeasured};
    kept[kept_count] = u;
    assigned_count += static_cast<std::size_t>(unreached);
    kept_count += static_cast<std::size_t>(!unreached);
  }
  return assigned_count;
}

template <typename Value>
void ensure_size(std::vector<Value>& buffer, std::size_t size) {
  if (buffer.size() < size) buffer.resize(2 * size);
}

}  // namespace

void GrowthIterations::seed(const std::vector<std::uint32_t>& seeds) {
  for (const std::uint32_t voxel : seeds) {
    const auto neighbors = adjacency_.of(voxel);
    if (check_.after(1 + neighbors.size())) return;
    if (state_.voxels[voxel].cluster != kNoCluster) continue;
    const std::uint32_t c = state_.add_cluster();
    state_.clusters[c].candidates.assign(neighbors.begin(), neighbors.end());
    ensure_size(state_.assigned, 1);
    state_.assigned[0] = {voxel, kUnreached};
    assign(c, 1);
    state_.clusters[c].center = state_.clusters[c].sum.mean(1);
  }
}

void GrowthIterations::run_first() {
  for (std::uint32_t c = 0; c < state_.cluster_count && !check_.after(1); ++c) {
    if (state_.clusters[c].count > 0) expand(c, assign_unreached);
  }
  update_centers();
}

bool GrowthIterations::run_next() {
  std::uint32_t prefetched = 0;
  for (std::uint32_t c = 0; c < state_.cluster_count && !check_.after(1); ++c) {
    if (!state_.clusters[c].can_expand()) continue;
    if (prefetched <= c) prefetched = prefetch_after(c);
    expand(c, [this](const Expansion& expansion, const std::uint32_t* candidates, std::size_t count,
                     AssignedVoxel* assigned, std::uint32_t* kept) {
      const Feature& center = state_.clusters[expansion.cluster].center;
      return kernels_.assign_candidates(expansion, weights_, center, candidates, count, assigned, kept);
    });
  }
  return update_centers();
}

/// Asks for the memory of the candidates of the next cluster that can expand, so that it arrives while cluster c does.
/// Returns that cluster.
std::uint32_t GrowthIterations::prefetch_after(std::uint32_t c) {
  do ++c;
  while (c < state_.cluster_count && !state_.clusters[c].can_expand());
  if (c == state_.cluster_count) return c;
  const std::vector<std::uint32_t>& candidates = state_.clusters[c].candidates;
  const std::size_t count = std::min(candidates.size(), kBlock);
  for (std::size_t i = 0; i < count; ++i) __builtin_prefetch(&state_.voxels[candidates[i]]);
  return c;
}

/// Expands a cluster by one layer of voxels at most. Its center stays where it is.
template <typename AssignCandidates>
void GrowthIterations::expand(std::uint32_t c, AssignCandidates&& assign_candidates) {
  const Expansion expansion{state_.voxels.data(), adjacency_.neighbor.data(), adjacency_.neighbor.size(), c,
                            ++state_.expansion_count};
  std::size_t count = split_candidates(expansion, assign_candidates);
  if (state_.clusters[c].has_lost_voxels) count = drop_separated(expansion, count);
  assign(c, count);
  add_candidates(expansion, count);
}

/// Moves candidates that will be assigned to the cluster to `state_.assigned`, and returns their number.
template <typename AssignCandidates>
std::size_t GrowthIterations::split_candidates(const Expansion& expansion, AssignCandidates&& assign_candidates) {
  std::vector<std::uint32_t>& candidates = state_.clusters[expansion.cluster].candidates;
  ensure_size(state_.assigned, candidates.size() + 1);
  std::size_t assigned = 0, kept = 0;
  for (std::size_t begin = 0; begin < candidates.size(); begin += kBlock) {
    const std::size_t count = std::min(kBlock, candidates.size() - begin);
    const std::size_t found = assign_candidates(expansion, candidates.data() + begin, count,
                                                state_.assigned.data() + assigned, candidates.data() + kept);
    assigned += found;
    kept += count - found;
    if (check_.after(count)) return 0;
  }
  candidates.resize(kept);
  return assigned;
}

/// Drops voxels that do not touch the cluster any more, because it lost their neighbors, from the first `count` of
/// `state_.assigned`. Returns how many are left.
std::size_t GrowthIterations::drop_separated(const Expansion& expansion, std::size_t count) {
  std::size_t kept = 0;
  for (std::size_t begin = 0; begin < count; begin += kBlock) {
    const std::size_t block = std::min(kBlock, count - begin);
    const QueryCounts counts =
        kernels_.keep_adjacent(expansion, state_.assigned.data() + begin, block, state_.assigned.data() + kept);
    kept += counts.found;
    if (check_.after(block + counts.visited)) return 0;
  }
  return kept;
}

/// Assigns the first `count` voxels of `state_.assigned` to cluster c.
void GrowthIterations::assign(std::uint32_t c, std::size_t count) {
  if (count == 0) return;
  FeatureSum sum = state_.clusters[c].sum;
  for (std::size_t i = 0; i < count; ++i) {
    const AssignedVoxel assigned = state_.assigned[i];
    Voxel& voxel = state_.voxels[assigned.voxel];
    if (voxel.cluster != kNoCluster) state_.clusters[voxel.cluster].lose(assigned.voxel, voxel.feature);
    sum.add(voxel.feature);
    voxel.cluster = c;
    voxel.distance = assigned.distance;
  }
  Cluster& cluster = state_.clusters[c];
  cluster.sum = sum;
  cluster.count += count;
  cluster.active_next = true;
}

/// Makes the neighbors of the first `count` voxels of `state_.assigned` candidates of the cluster, too.
void GrowthIterations::add_candidates(const Expansion& expansion, std::size_t count) {
  std::size_t found = 0;
  for (std::size_t begin = 0; begin < count; begin += kBlock) {
    const std::size_t block = std::min(kBlock, count - begin);
    ensure_size(state_.new_candidates, found + block * state_.most_neighbors + 1);
    const QueryCounts counts = kernels_.find_new_candidates(expansion, state_.assigned.data() + begin, block,
                                                            state_.new_candidates.data() + found);
    found += counts.found;
    if (check_.after(block + counts.visited)) return;
  }
  std::vector<std::uint32_t>& candidates = state_.clusters[expansion.cluster].candidates;
  const auto first = state_.new_candidates.begin();
  candidates.insert(candidates.end(), first, first + static_cast<std::ptrdiff_t>(found));
}

/// Ends an iteration. Returns whether it changed anything.
bool GrowthIterations::update_centers() {
  bool any = false;
  check_.for_each(0, state_.cluster_count, [&](std::size_t c) {
    Cluster& cluster = state_.clusters[c];
    any |= cluster.active_next;
    if (cluster.active_next && cluster.count > 0) cluster.center = cluster.sum.mean(cluster.count);
    cluster.active = cluster.active_next;
    cluster.active_next = false;
  });
  return any && !check_.stopped();
}

}  // namespace segserve::growth
