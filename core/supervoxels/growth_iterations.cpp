#include "core/supervoxels/growth_iterations.hpp"

#include <algorithm>
#include <limits>

namespace segserve::growth {
namespace {

constexpr std::size_t kTogether = 256;                             // candidates, or claims
constexpr std::size_t kCached = 25'000;                            // voxels; two megabytes
constexpr float kProvisional = std::numeric_limits<float>::max();  // any measured distance is nearer

/// A kernel in its place in the first round: whatever no one has reached yet is near enough.
std::size_t find_unreached(const Turn& turn, const std::uint32_t* candidates, std::size_t count, Claim* claims,
                           std::uint32_t* kept) {
  std::size_t claimed = 0, left = 0;
  for (std::size_t i = 0; i < count; ++i) {
    const std::uint32_t u = candidates[i];
    const bool unreached = turn.voxels[u].distance == kUnreached;
    turn.voxels[u].seen = turn.number;
    claims[claimed] = {u, kProvisional};
    kept[left] = u;
    claimed += static_cast<std::size_t>(unreached);
    left += static_cast<std::size_t>(!unreached);
  }
  return claimed;
}

template <typename Value>
void make_room(std::vector<Value>& values, std::size_t count) {
  if (values.size() < count) values.resize(2 * count);
}

}  // namespace

void Rounds::plant(const std::vector<std::uint32_t>& seeds) {
  for (const std::uint32_t seed : seeds) {
    if (check_.after(1 + adjacency_.of(seed).size())) return;
    if (state_.voxels[seed].owner != kNobody) continue;
    const std::uint32_t c = state_.new_cluster();
    const auto neighbors = adjacency_.of(seed);
    state_.clusters[c].candidates.assign(neighbors.begin(), neighbors.end());
    make_room(state_.claims, 1);
    state_.claims[0] = {seed, kUnreached};
    take(c, 1);
    state_.clusters[c].centre = state_.clusters[c].sum.mean(1);
  }
}

void Rounds::first() {
  for (std::uint32_t c = 0; c < state_.cluster_count && !check_.after(1); ++c) {
    if (state_.clusters[c].count == 0) continue;
    expand(c, find_unreached);
  }
  move_centres();
}

bool Rounds::next() {
  for (std::uint32_t c = 0; c < state_.cluster_count && !check_.after(1); ++c) {
    if (!state_.clusters[c].takes_turn()) continue;
    prefetch_turns_after(c);
    expand(c, [this](const Turn& turn, const std::uint32_t* candidates, std::size_t count, Claim* claims,
                     std::uint32_t* kept) {
      const Feature& centre = state_.clusters[turn.cluster].centre;
      return kernels_.find_claims(turn, distance_, centre, candidates, count, claims, kept);
    });
  }
  return move_centres();
}

/// The next cluster that takes a turn, as things stand.
std::uint32_t Rounds::turn_after(std::uint32_t c) const {
  while (++c < state_.cluster_count && !state_.clusters[c].takes_turn()) {
  }
  return c;
}

/// Where the voxels are more than the cache holds: brings in what candidates of the next turn name, and the list of the
/// turn after that. A twelfth off growth of a full frame, a quarter of ten million points.
void Rounds::prefetch_turns_after(std::uint32_t c) const {
  if (state_.voxels.size() < kCached) return;
  constexpr std::size_t kLine = 64 / sizeof(std::uint32_t);
  const std::uint32_t next = turn_after(c);
  if (next == state_.cluster_count) return;
  for (const std::uint32_t v : state_.clusters[next].candidates) __builtin_prefetch(&state_.voxels[v]);
  const std::uint32_t second = turn_after(next);
  if (second == state_.cluster_count) return;
  const std::vector<std::uint32_t>& list = state_.clusters[second].candidates;
  for (std::size_t i = 0; i < list.size(); i += kLine) __builtin_prefetch(list.data() + i);
}

/// There as well: the neighbours of the claims, which what follows goes through. A twentieth of ten million points.
void Rounds::prefetch_rows(const Turn& turn, std::size_t claims) const {
  if (state_.voxels.size() < kCached) return;
  for (std::size_t i = 0; i < claims; ++i) {
    __builtin_prefetch(turn.neighbor + state_.voxels[state_.claims[i].voxel].first);
  }
}

/// One turn of a cluster: its centre stays where it is, and what it takes now expands next time.
template <typename FindClaims>
void Rounds::expand(std::uint32_t c, FindClaims&& find_claims) {
  const Turn turn{state_.voxels.data(), adjacency_.neighbor.data(), adjacency_.neighbor.size(), c, ++state_.turn};
  std::size_t claims = split_candidates(turn, find_claims);
  prefetch_rows(turn, claims);
  if (state_.clusters[c].lost) claims = drop_claims_that_do_not_touch(turn, claims);
  take(c, claims);
  add_candidates(turn, claims);
}

/// The candidates that are nearer to the cluster than to their owners become claims; the others stay candidates.
/// Returns the number of claims.
template <typename FindClaims>
std::size_t Rounds::split_candidates(const Turn& turn, FindClaims&& find_claims) {
  std::vector<std::uint32_t>& candidates = state_.clusters[turn.cluster].candidates;
  make_room(state_.claims, candidates.size() + 1);
  std::size_t claims = 0, kept = 0;
  for (std::size_t begin = 0; begin < candidates.size(); begin += kTogether) {
    const std::size_t count = std::min(kTogether, candidates.size() - begin);
    const std::size_t found =
        find_claims(turn, candidates.data() + begin, count, state_.claims.data() + claims, candidates.data() + kept);
    claims += found;
    kept += count - found;
    if (check_.after(count)) return 0;
  }
  candidates.resize(kept);
  return claims;
}

/// Where the cluster has lost voxels, what touched them may not touch it any more, and is no candidate then.
std::size_t Rounds::drop_claims_that_do_not_touch(const Turn& turn, std::size_t claims) {
  std::size_t kept = 0;
  for (std::size_t begin = 0; begin < claims; begin += kTogether) {
    const std::size_t count = std::min(kTogether, claims - begin);
    const Found found = kernels_.keep_touching(turn, state_.claims.data() + begin, count, state_.claims.data() + kept);
    kept += found.count;
    if (check_.after(count + found.visits)) return 0;
  }
  return kept;
}

/// Cluster c gets the voxels that it claims. Its sums stay in registers meanwhile.
void Rounds::take(std::uint32_t c, std::size_t claims) {
  if (claims == 0) return;
  FeatureSum sum = state_.clusters[c].sum;
  for (std::size_t i = 0; i < claims; ++i) {
    const Claim claim = state_.claims[i];
    Voxel& voxel = state_.voxels[claim.voxel];
    if (voxel.owner != kNobody) state_.clusters[voxel.owner].lose(claim.voxel, voxel.feature);
    sum.add(voxel.feature);
    voxel.owner = c;
    voxel.distance = claim.distance;
  }
  Cluster& winner = state_.clusters[c];
  winner.sum = sum;
  winner.count += claims;
  winner.changed_next = true;
}

/// What the claims touch beyond the cluster becomes its candidates, too.
void Rounds::add_candidates(const Turn& turn, std::size_t claims) {
  std::size_t fresh = 0;
  for (std::size_t begin = 0; begin < claims; begin += kTogether) {
    const std::size_t count = std::min(kTogether, claims - begin);
    make_room(state_.fresh, fresh + count * state_.most_neighbors + 1);
    const Found found = kernels_.find_fresh(turn, state_.claims.data() + begin, count, state_.fresh.data() + fresh);
    fresh += found.count;
    if (check_.after(count + found.visits)) return;
  }
  std::vector<std::uint32_t>& candidates = state_.clusters[turn.cluster].candidates;
  candidates.insert(candidates.end(), state_.fresh.begin(), state_.fresh.begin() + static_cast<std::ptrdiff_t>(fresh));
}

bool Rounds::move_centres() {
  bool any = false;
  check_.for_each(0, state_.cluster_count, [&](std::size_t c) {
    Cluster& cluster = state_.clusters[c];
    any |= cluster.changed_next;
    if (cluster.changed_next && cluster.count > 0) cluster.centre = cluster.sum.mean(cluster.count);
    cluster.changed = cluster.changed_next;
    cluster.changed_next = false;
  });
  return any && !check_.stopped();
}

}  // namespace segserve::growth
