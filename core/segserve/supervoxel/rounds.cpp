#include "segserve/supervoxel/rounds.hpp"

#include <algorithm>
#include <array>
#include <limits>

namespace segserve::growth {
namespace {

constexpr std::size_t kTogether = 128;                             // candidates
constexpr float kProvisional = std::numeric_limits<float>::max();  // any measured distance is nearer

}  // namespace

void Rounds::plant(const std::vector<std::uint32_t>& seeds) {
  for (const std::uint32_t seed : seeds) {
    if (check_.after(1 + adjacency_.of(seed).size())) return;
    if (state_.owner[seed] != kNobody) continue;
    const std::uint32_t c = state_.new_cluster();
    const auto neighbors = adjacency_.of(seed);
    state_.clusters[c].candidates.assign(neighbors.begin(), neighbors.end());
    take({seed, c, kUnreached});
    state_.clusters[c].centre = state_.clusters[c].sum.mean(1);
  }
}

void Rounds::first() {
  for (std::uint32_t c = 0; c < state_.cluster_count && !check_.after(1); ++c) {
    if (state_.clusters[c].count == 0) continue;
    expand(c, [](std::uint32_t, const std::uint32_t*, std::size_t count, float* out) {
      std::fill_n(out, count, kProvisional);
    });
  }
  move_centres();
}

bool Rounds::next() {
  for (std::uint32_t c = 0; c < state_.cluster_count && !check_.after(1); ++c) {
    if (state_.clusters[c].count > 0 && state_.clusters[c].changed) {
      prefetch_turns_after(c);
      expand(c, [this](std::uint32_t cluster, const std::uint32_t* of, std::size_t count, float* out) {
        distance_.measure(state_.clusters[cluster].centre, state_.voxels.data(), of, count, out);
      });
    }
  }
  return move_centres();
}

/// Where the voxels are more than the cache holds: brings in the lists of the turn after next, and what those of the
/// next one name. A seventh off growth of a million points, nothing off that of a frame.
void Rounds::prefetch_turns_after(std::uint32_t c) const {
  constexpr std::size_t kLine = 64 / sizeof(std::uint32_t);
  if (c + 2 >= state_.cluster_count || !state_.clusters[c + 1].changed) return;
  const std::vector<std::uint32_t>& list = state_.clusters[c + 2].candidates;
  for (std::size_t i = 0; i < list.size(); i += kLine) __builtin_prefetch(list.data() + i);
  for (const std::uint32_t v : state_.clusters[c + 1].candidates) __builtin_prefetch(&state_.voxels[v]);
}

/// One turn of a cluster: its centre stays where it is, and what it takes now expands next time.
template <typename Measure>
void Rounds::expand(std::uint32_t c, Measure&& measure) {
  ++state_.turn;
  std::size_t claims = find_claims(c, measure);
  for (std::size_t i = 0; i < claims; ++i) __builtin_prefetch(adjacency_.of(state_.claims[i].voxel).data());
  if (state_.clusters[c].lost) claims = drop_claims_that_do_not_touch(claims);
  std::size_t fresh = 0;
  check_.for_each(0, claims, [&](std::size_t i) {
    take(state_.claims[i]);
    fresh = add_candidates_around(state_.claims[i].voxel, c, fresh);
    return 1 + adjacency_.of(state_.claims[i].voxel).size();
  });
  std::vector<std::uint32_t>& candidates = state_.clusters[c].candidates;
  candidates.insert(candidates.end(), state_.fresh.begin(), state_.fresh.begin() + static_cast<std::ptrdiff_t>(fresh));
}

/// The candidates that are nearer to cluster c than to their owners become claims; the others stay candidates.
/// Returns the number of claims. No branches: they would be mispredicted for every fourth candidate.
template <typename Measure>
std::size_t Rounds::find_claims(std::uint32_t c, Measure&& measure) {
  std::vector<std::uint32_t>& candidates = state_.clusters[c].candidates;
  if (state_.claims.size() <= candidates.size()) state_.claims.resize(2 * candidates.size() + 1);
  std::size_t claims = 0, kept = 0;
  const auto find_some = [&](std::size_t begin, std::size_t end) {
    std::array<float, kTogether> distance;
    measure(c, candidates.data() + begin, end - begin, distance.data());
    std::uint32_t* candidate = candidates.data();
    std::uint32_t* seen = state_.seen.data();
    Claim* claim = state_.claims.data();
    std::size_t claimed = claims, left = kept;
    for (std::size_t i = begin; i < end; ++i) {
      const std::uint32_t u = candidate[i];
      const float d = distance[i - begin];
      const bool nearer = d < state_.voxels[u].distance;
      seen[u] = state_.turn;
      claim[claimed] = {u, c, d};
      candidate[left] = u;
      claimed += static_cast<std::size_t>(nearer);
      left += static_cast<std::size_t>(!nearer);
    }
    claims = claimed, kept = left;
  };
  for (std::size_t begin = 0; begin < candidates.size(); begin += kTogether) {
    const std::size_t end = std::min(begin + kTogether, candidates.size());
    find_some(begin, end);
    if (check_.after(end - begin)) return 0;
  }
  candidates.resize(kept);
  return claims;
}

/// Where the cluster has lost voxels, what touched them may not touch it any more, and is no candidate then.
std::size_t Rounds::drop_claims_that_do_not_touch(std::size_t claims) {
  std::size_t kept = 0;
  check_.for_each(0, claims, [&](std::size_t i) {
    const Claim claim = state_.claims[i];
    const bool touching = touches(claim.voxel, claim.cluster);
    state_.claims[kept] = claim;
    kept += static_cast<std::size_t>(touching);
    if (!touching) state_.seen[claim.voxel] = 0;
    return 1 + adjacency_.of(claim.voxel).size();
  });
  return kept;
}

bool Rounds::touches(std::uint32_t v, std::uint32_t c) const {
  const auto neighbors = adjacency_.of(v);
  return std::any_of(neighbors.begin(), neighbors.end(), [&](std::uint32_t u) { return state_.owner[u] == c; });
}

/// Appends the foreign neighbours of v that are no candidates of c yet to the `fresh` ones; returns their number.
std::size_t Rounds::add_candidates_around(std::uint32_t v, std::uint32_t c, std::size_t fresh) {
  const auto neighbors = adjacency_.of(v);
  if (state_.fresh.size() <= fresh + neighbors.size()) state_.fresh.resize(2 * (fresh + neighbors.size()) + 1);
  const std::uint32_t turn = state_.turn;
  const std::uint32_t* owner = state_.owner.data();
  std::uint32_t* seen = state_.seen.data();
  std::uint32_t* out = state_.fresh.data();
  for (const std::uint32_t u : neighbors) {
    out[fresh] = u;
    fresh += static_cast<std::size_t>(owner[u] != c) & static_cast<std::size_t>(seen[u] != turn);
    seen[u] = turn;
  }
  return fresh;
}

void Rounds::take(const Claim& claim) {
  Voxel& voxel = state_.voxels[claim.voxel];
  std::uint32_t& owner = state_.owner[claim.voxel];
  if (owner != kNobody) {
    Cluster& loser = state_.clusters[owner];
    --loser.count;
    loser.sum.add(voxel.feature, -1);
    loser.candidates.push_back(claim.voxel);
    loser.changed = loser.changed_next = loser.lost = true;
  }
  Cluster& winner = state_.clusters[claim.cluster];
  ++winner.count;
  winner.sum.add(voxel.feature, 1);
  winner.changed_next = true;
  owner = claim.cluster;
  voxel.distance = claim.distance;
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
