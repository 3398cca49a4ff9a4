#include "segserve/supervoxel/growth.hpp"

#include <algorithm>
#include <array>
#include <limits>

#include "segserve/supervoxel/clusters.hpp"
#include "segserve/supervoxel/distances.hpp"

namespace segserve {

using namespace growth;

struct GrowthScratch::Buffers {
  std::vector<Voxel> voxels;
  std::vector<Cluster> clusters;  // more than there are, so that their candidates keep their memory
  std::vector<std::uint32_t> owner, seen;
  std::vector<Claim> claims;
  std::vector<std::uint32_t> rest, number, fresh;
};

GrowthScratch::GrowthScratch() : buffers_(std::make_unique<Buffers>()) {}
GrowthScratch::~GrowthScratch() = default;
GrowthScratch::GrowthScratch(GrowthScratch&&) noexcept = default;
GrowthScratch& GrowthScratch::operator=(GrowthScratch&&) noexcept = default;

namespace {

constexpr std::size_t kTogether = 128;  // candidates
constexpr float kProvisional = std::numeric_limits<float>::max();  // any measured distance is nearer

class Growth {
 public:
  Growth(const VoxelGrid& grid, const VoxelAdjacency& adjacency, const std::vector<Vec3>& normals,
         const SupervoxelOptions& options, const StopToken& stop, GrowthScratch::Buffers& buffers)
      : adjacency_(adjacency),
        check_(stop),
        distance_(static_cast<float>(options.normal_weight)),
        voxels_(buffers.voxels),
        owner_(buffers.owner),
        seen_(buffers.seen),
        clusters_(buffers.clusters),
        claims_(buffers.claims),
        rest_(buffers.rest),
        number_(buffers.number),
        fresh_(buffers.fresh) {
    const double position_scale = options.spatial_weight / options.seed_resolution;
    voxels_.resize(grid.size());
    owner_.assign(grid.size(), kNobody);
    seen_.assign(grid.size(), 0);
    check_.for_each(0, grid.size(), [&](std::size_t v) {
      const Vec3 p = position_scale * grid.centroid[v];
      const Vec3 c = (options.color_weight / 255 / grid.points[v]) * grid.color_sum[v];
      voxels_[v] = {Feature::of(p, c, normals[v]), kUnreached};
    });
  }

  void plant(const std::vector<std::uint32_t>& seeds) {
    for (const std::uint32_t seed : seeds) {
      if (check_.after(1 + adjacency_.of(seed).size())) return;
      if (owner_[seed] != kNobody) continue;
      const std::uint32_t c = new_cluster();
      const auto neighbors = adjacency_.of(seed);
      clusters_[c].candidates.assign(neighbors.begin(), neighbors.end());
      take({seed, c, kUnreached});
      clusters_[c].centre = clusters_[c].sum.mean(1);
    }
  }

  /// PCL's first round measures from the origin, so that what counts is who comes first: a seed next
  /// to an earlier one is taken by it and dies. That thins the seeds out well, so we do it on purpose.
  void first_round() {
    for (std::uint32_t c = 0; c < cluster_count_ && !check_.after(1); ++c) {
      if (clusters_[c].count == 0) continue;
      expand(c, [](std::uint32_t, const std::uint32_t*, std::size_t count, float* out) {
        std::fill_n(out, count, kProvisional);
      });
    }
    move_centres();
  }

  /// Returns whether anything changed.
  bool round() {
    for (std::uint32_t c = 0; c < cluster_count_ && !check_.after(1); ++c) {
      if (clusters_[c].count > 0 && clusters_[c].changed) {
        expand(c, [this](std::uint32_t cluster, const std::uint32_t* of, std::size_t count, float* out) {
          distance_.measure(clusters_[cluster].centre, voxels_.data(), of, count, out);
        });
      }
    }
    return move_centres();
  }

  /// The rest: the voxels without owner.
  void find_rest() {
    rest_.clear();
    check_.for_each(0, voxels_.size(), [&](std::size_t v) {
      if (owner_[v] == kNobody) rest_.push_back(static_cast<std::uint32_t>(v));
    });
  }

  /// Layer by layer, gives voxels without owner to the nearest cluster that touches them. What touches a cluster in one
  /// layer and did not before touches a voxel of the layer before: no need to go through the whole rest each time.
  void reach_the_rest() {
    trim_rest();
    claims_.clear();
    ++turn_;
    check_.for_each(0, rest_.size(), [&](std::size_t i) { return 1 + claim_for_nearest(rest_[i]); });
    std::size_t begin = 0;
    while (begin < claims_.size() && !check_.stopped()) {
      const std::size_t end = claims_.size();
      check_.for_each(begin, end, [&](std::size_t i) { owner_[claims_[i].voxel] = claims_[i].cluster; });
      check_.for_each(begin, end, [&](std::size_t i) {
        std::size_t work = 1;
        for (const std::uint32_t u : adjacency_.of(claims_[i].voxel)) work += 1 + claim_for_nearest(u);
        return work;
      });
      begin = end;
    }
  }

  /// Components that no seed lies in: one cluster each, from the smallest voxel.
  void adopt_components() {
    for (const std::uint32_t first : rest_) {
      if (check_.after(1)) return;
      if (owner_[first] != kNobody) continue;
      const std::uint32_t c = new_cluster();
      claims_.assign(1, {first, c, 0});
      owner_[first] = c;
      for (std::size_t i = 0; i < claims_.size(); ++i) {
        const auto neighbors = adjacency_.of(claims_[i].voxel);
        if (check_.after(1 + neighbors.size())) return;
        for (const std::uint32_t u : neighbors) {
          if (owner_[u] != kNobody) continue;
          owner_[u] = c;
          claims_.push_back({u, c, 0});
        }
      }
    }
  }

  void number(Supervoxels& result) {
    result.count = 0;
    result.of_voxel.resize(voxels_.size());
    number_.assign(cluster_count_, kNobody);
    check_.for_each(0, voxels_.size(), [&](std::size_t v) {
      std::uint32_t& n = number_[owner_[v]];
      if (n == kNobody) n = result.count++;
      result.of_voxel[v] = n;
    });
  }

 private:
  std::uint32_t new_cluster() {
    if (cluster_count_ == clusters_.size()) clusters_.emplace_back();
    clusters_[cluster_count_].clear();
    return cluster_count_++;
  }

  /// One turn of a cluster: its centre stays where it is, and what it takes now expands next time.
  template <typename Measure>
  void expand(std::uint32_t c, Measure&& measure) {
    ++turn_;
    std::size_t claims = find_claims(c, measure);
    if (clusters_[c].lost) claims = drop_claims_that_do_not_touch(claims);
    std::size_t fresh = 0;
    check_.for_each(0, claims, [&](std::size_t i) {
      take(claims_[i]);
      fresh = add_candidates_around(claims_[i].voxel, c, fresh);
      return 1 + adjacency_.of(claims_[i].voxel).size();
    });
    std::vector<std::uint32_t>& candidates = clusters_[c].candidates;
    candidates.insert(candidates.end(), fresh_.begin(), fresh_.begin() + static_cast<std::ptrdiff_t>(fresh));
  }

  /// The candidates that are nearer to cluster c than to their owners become claims; the others stay candidates.
  /// Returns the number of claims. No branches: they would be mispredicted for every fourth candidate.
  template <typename Measure>
  std::size_t find_claims(std::uint32_t c, Measure&& measure) {
    std::vector<std::uint32_t>& candidates = clusters_[c].candidates;
    if (claims_.size() <= candidates.size()) claims_.resize(2 * candidates.size() + 1);
    std::size_t claims = 0, kept = 0;
    const auto find_some = [&](std::size_t begin, std::size_t end) {
      std::array<float, kTogether> distance;
      measure(c, candidates.data() + begin, end - begin, distance.data());
      std::uint32_t* candidate = candidates.data();
      std::uint32_t* seen = seen_.data();
      Claim* claim = claims_.data();
      std::size_t claimed = claims, left = kept;
      for (std::size_t i = begin; i < end; ++i) {
        const std::uint32_t u = candidate[i];
        const float d = distance[i - begin];
        const bool nearer = d < voxels_[u].distance;
        seen[u] = turn_;
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
  std::size_t drop_claims_that_do_not_touch(std::size_t claims) {
    std::size_t kept = 0;
    check_.for_each(0, claims, [&](std::size_t i) {
      const Claim claim = claims_[i];
      const bool touching = touches(claim.voxel, claim.cluster);
      claims_[kept] = claim;
      kept += static_cast<std::size_t>(touching);
      if (!touching) seen_[claim.voxel] = 0;
      return 1 + adjacency_.of(claim.voxel).size();
    });
    return kept;
  }

  bool touches(std::uint32_t v, std::uint32_t c) const {
    const auto neighbors = adjacency_.of(v);
    return std::any_of(neighbors.begin(), neighbors.end(), [&](std::uint32_t u) { return owner_[u] == c; });
  }

  /// Appends the foreign neighbours of v that are no candidates of c yet to the `fresh` ones; returns their number.
  std::size_t add_candidates_around(std::uint32_t v, std::uint32_t c, std::size_t fresh) {
    const auto neighbors = adjacency_.of(v);
    if (fresh_.size() <= fresh + neighbors.size()) fresh_.resize(2 * (fresh + neighbors.size()) + 1);
    const std::uint32_t turn = turn_;
    const std::uint32_t* owner = owner_.data();
    std::uint32_t* seen = seen_.data();
    std::uint32_t* out = fresh_.data();
    for (const std::uint32_t u : neighbors) {
      out[fresh] = u;
      fresh += static_cast<std::size_t>(owner[u] != c) & static_cast<std::size_t>(seen[u] != turn);
      seen[u] = turn;
    }
    return fresh;
  }

  void take(const Claim& claim) {
    Voxel& voxel = voxels_[claim.voxel];
    std::uint32_t& owner = owner_[claim.voxel];
    if (owner != kNobody) {
      Cluster& loser = clusters_[owner];
      --loser.count;
      loser.sum.add(voxel.feature, -1);
      loser.candidates.push_back(claim.voxel);
      loser.changed = loser.changed_next = loser.lost = true;
    }
    Cluster& winner = clusters_[claim.cluster];
    ++winner.count;
    winner.sum.add(voxel.feature, 1);
    winner.changed_next = true;
    owner = claim.cluster;
    voxel.distance = claim.distance;
  }

  bool move_centres() {
    bool any = false;
    check_.for_each(0, cluster_count_, [&](std::size_t c) {
      Cluster& cluster = clusters_[c];
      any |= cluster.changed_next;
      if (cluster.changed_next && cluster.count > 0) cluster.centre = cluster.sum.mean(cluster.count);
      cluster.changed = cluster.changed_next;
      cluster.changed_next = false;
    });
    return any && !check_.stopped();
  }

  /// Voxel v, if it is free, is claimed for the nearest cluster that touches it, but once. Returns the work.
  std::size_t claim_for_nearest(std::uint32_t v) {
    if (owner_[v] != kNobody || seen_[v] == turn_) return 0;
    const auto neighbors = adjacency_.of(v);
    std::uint32_t nearest = kNobody;
    float smallest = kUnreached;
    for (const std::uint32_t u : neighbors) {
      const std::uint32_t c = owner_[u];
      if (c == kNobody) continue;
      const float d = distance_(clusters_[c].centre, voxels_[v].feature);
      if (d < smallest || (d == smallest && c < nearest)) smallest = d, nearest = c;
    }
    if (nearest != kNobody) {
      seen_[v] = turn_;
      claims_.push_back({v, nearest, 0});
    }
    return neighbors.size();
  }

  /// Leaves only voxels without owner in the rest.
  void trim_rest() {
    std::size_t kept = 0;
    const bool complete = check_.for_each(0, rest_.size(), [&](std::size_t i) {
      if (owner_[rest_[i]] == kNobody) rest_[kept++] = rest_[i];
    });
    if (complete) rest_.resize(kept);
  }

  const VoxelAdjacency& adjacency_;
  StopCheck check_;
  Distance distance_;
  std::vector<Voxel>& voxels_;
  std::vector<std::uint32_t>& owner_;  // a cluster
  std::vector<std::uint32_t>& seen_;   // the last turn that had the voxel among its candidates
  std::vector<Cluster>& clusters_;
  std::vector<Claim>& claims_;
  std::vector<std::uint32_t>& rest_;  // voxels without owner, ascending
  std::vector<std::uint32_t>& number_;
  std::vector<std::uint32_t>& fresh_;  // candidates that a turn adds
  std::uint32_t cluster_count_ = 0;
  std::uint32_t turn_ = 0;
};

}  // namespace

absl::Status grow_supervoxels(const VoxelGrid& grid, const VoxelAdjacency& adjacency, const std::vector<Vec3>& normals,
                              const Seeds& seeds, const SupervoxelOptions& options, const StopToken& stop,
                              GrowthScratch& scratch, Supervoxels& supervoxels) {
  const auto rounds = static_cast<int>(1.8 * options.seed_resolution / options.voxel_resolution + 1e-6) - 1;
  Growth growth(grid, adjacency, normals, options, stop, scratch.buffers());
  if (absl::Status status = stop.check(); !status.ok()) return status;
  growth.plant(seeds.chosen);
  growth.first_round();
  for (int round = 1; round < rounds; ++round) {
    if (absl::Status status = stop.check(); !status.ok()) return status;
    if (!growth.round()) break;
  }
  growth.find_rest();
  growth.reach_the_rest();
  growth.plant(seeds.sparse);
  growth.reach_the_rest();
  growth.adopt_components();
  if (absl::Status status = stop.check(); !status.ok()) return status;
  growth.number(supervoxels);
  return stop.check();
}

}  // namespace segserve
