#include "segserve/supervoxel/rounds.hpp"

#include <algorithm>
#include <limits>

namespace segserve::growth {
namespace {

constexpr std::size_t kTogether = 256;                             // candidates, or claims
constexpr float kProvisional = std::numeric_limits<float>::max();  // any measured distance is nearer

/// A kernel in its place in the first round: whatever no one has reached yet is near enough.
std::size_t find_unreached(const Turn& turn, const std::uint32_t* candidates, std::size_t count, Claim* claims,
                           std::uint32_t* kept) {
  std::size_t claimed = 0, left = 0;
  for (std::size_t i = 0; i < count; ++i) {
    const std::uint32_t u = candidates[i];
    const bool unreached = turn.voxels[u].distance == kUnreached;
    turn.seen[u] = turn.number;
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
    if (state_.owner[seed] != kNobody) continue;
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
    if (state_.clusters[c].count > 0 && state_.clusters[c].changed) {
      prefetch_turns_after(c);
      expand(c, [this](const Turn& turn, const std::uint32_t* candidates, std::size_t count, Claim* claims,
                       std::uint32_t* kept) {
        const Feature& centre = state_.clusters[turn.cluster].centre;
        return kernels_.find_claims(turn, distance_, centre, candidates, count, claims, kept);
      });
    }
  }
  return move_centres();
}

/// Where the voxels are more than the cache holds: brings in the lists of the turn after next, and what those of the
/// next one name. A twelfth off growth of a full frame, a seventh of a million points.
void Rounds::prefetch_turns_after(std::uint32_t c) const {
  constexpr std::size_t kCached = 25'000;  // voxels; a megabyte
  if (state_.voxels.size() < kCached) return;
  constexpr std::size_t kLine = 64 / sizeof(std::uint32_t);
  if (c + 2 >= state_.cluster_count || !state_.clusters[c + 1].changed) return;
  const std::vector<std::uint32_t>& list = state_.clusters[c + 2].candidates;
  for (std::size_t i = 0; i < list.size(); i += kLine) __builtin_prefetch(list.data() + i);
  for (const std::uint32_t v : state_.clusters[c + 1].candidates) __builtin_prefetch(&state_.voxels[v]);
}

/// One turn of a cluster: its centre stays where it is, and what it takes now expands next time.
template <typename FindClaims>
void Rounds::expand(std::uint32_t c, FindClaims&& find_claims) {
  const Turn turn{state_.voxels.data(),
                  state_.owner.data(),
                  state_.seen.data(),
                  adjacency_.offset.data(),
                  adjacency_.neighbor.data(),
                  adjacency_.neighbor.size(),
                  c,
                  ++state_.turn};
  std::size_t claims = split_candidates(turn, find_claims);
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

/// The neighbours of the voxels that claims [begin, end) are about.
std::size_t Rounds::count_neighbors(std::size_t begin, std::size_t end) const {
  std::size_t count = 0;
  for (std::size_t i = begin; i < end; ++i) count += adjacency_.of(state_.claims[i].voxel).size();
  return count;
}

/// Where the cluster has lost voxels, what touched them may not touch it any more, and is no candidate then.
std::size_t Rounds::drop_claims_that_do_not_touch(const Turn& turn, std::size_t claims) {
  std::size_t kept = 0;
  for (std::size_t begin = 0; begin < claims; begin += kTogether) {
    const std::size_t end = std::min(begin + kTogether, claims);
    const std::size_t work = end - begin + count_neighbors(begin, end);
    kept += kernels_.keep_touching(turn, state_.claims.data() + begin, end - begin, state_.claims.data() + kept);
    if (check_.after(work)) return 0;
  }
  return kept;
}

/// Cluster c gets the voxels that it claims. Its sums stay in registers meanwhile.
void Rounds::take(std::uint32_t c, std::size_t claims) {
  if (claims == 0) return;
  FeatureSum sum = state_.clusters[c].sum;
  for (std::size_t i = 0; i < claims; ++i) {
    const Claim claim = state_.claims[i];
    Feature& voxel = state_.voxels[claim.voxel];
    std::uint32_t& owner = state_.owner[claim.voxel];
    if (owner != kNobody) state_.clusters[owner].lose(claim.voxel, voxel);
    sum.add(voxel);
    owner = c;
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
    const std::size_t end = std::min(begin + kTogether, claims);
    const std::size_t neighbors = count_neighbors(begin, end);
    make_room(state_.fresh, fresh + neighbors + 1);
    fresh += kernels_.find_fresh(turn, state_.claims.data() + begin, end - begin, state_.fresh.data() + fresh);
    if (check_.after(end - begin + neighbors)) return;
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
