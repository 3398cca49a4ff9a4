#include "segserve/supervoxel/growth.hpp"

#include <cmath>
#include <limits>

namespace segserve {
namespace {

constexpr std::uint32_t kNobody = std::numeric_limits<std::uint32_t>::max();
constexpr float kUnreached = std::numeric_limits<float>::infinity();
constexpr float kProvisional = std::numeric_limits<float>::max();  // any measured distance is nearer

/// What distances are measured on, scaled by the weights: position, colour, normal.
struct Feature {
  float px, py, pz, cr, cg, cb, nx, ny, nz;
};

struct FeatureSum {
  Vec3 position, color, normal;

  void add(const Feature& f, double sign) {
    position += sign * Vec3{f.px, f.py, f.pz};
    color += sign * Vec3{f.cr, f.cg, f.cb};
    normal += sign * Vec3{f.nx, f.ny, f.nz};
  }
  Feature mean(std::size_t count) const {
    const double scale = 1 / static_cast<double>(count);
    const Vec3 p = scale * position;
    const Vec3 c = scale * color;
    const Vec3 n = unit(normal);
    const auto f = [](double v) { return static_cast<float>(v); };
    return {f(p.x), f(p.y), f(p.z), f(c.x), f(c.y), f(c.z), f(n.x), f(n.y), f(n.z)};
  }
};

struct Cluster {
  std::vector<std::uint32_t> voxels;  // may name voxels lost since the cluster's last turn
  std::size_t count = 0;              // voxels it owns
  FeatureSum sum;
  Feature centre{};
  // Nothing changes at the turn of a cluster that neither gained nor lost since its last one.
  bool changed = true;
  bool changed_next = false;
};

class Growth {
 public:
  Growth(const VoxelGrid& grid, const VoxelAdjacency& adjacency, const std::vector<Vec3>& normals,
         const SupervoxelOptions& options, const StopToken& stop)
      : adjacency_(adjacency),
        check_(stop),
        normal_weight_(static_cast<float>(options.normal_weight)),
        owner_(grid.size(), kNobody),
        distance_(grid.size(), kUnreached),
        seen_(grid.size(), 0) {
    const double position_scale = options.spatial_weight / options.seed_resolution;
    features_.reserve(grid.size());
    check_.for_each(0, grid.size(), [&](std::size_t v) {
      const Vec3 p = position_scale * grid.centroid[v];
      const Vec3 c = (options.color_weight / 255 / grid.points[v]) * grid.color_sum[v];
      const Vec3& n = normals[v];
      const auto f = [](double value) { return static_cast<float>(value); };
      features_.push_back({f(p.x), f(p.y), f(p.z), f(c.x), f(c.y), f(c.z), f(n.x), f(n.y), f(n.z)});
    });
  }

  void plant(const std::vector<std::uint32_t>& seeds) {
    for (const std::uint32_t seed : seeds) {
      if (check_.after(1)) return;
      if (owner_[seed] != kNobody) continue;
      const auto c = static_cast<std::uint32_t>(clusters_.size());
      clusters_.emplace_back();
      take(c, seed, kUnreached);
      clusters_[c].centre = clusters_[c].sum.mean(1);
    }
  }

  /// PCL's first round measures from the origin, so that what counts is who comes first: a seed next
  /// to an earlier one is taken by it and dies. That thins the seeds out well, so we do it on purpose.
  void first_round() {
    for (std::uint32_t c = 0; c < clusters_.size() && !check_.after(1); ++c) {
      expand(c, [](const Feature&, const Feature&) { return kProvisional; });
    }
    move_centres();
  }

  /// Returns whether anything changed.
  bool round() {
    for (std::uint32_t c = 0; c < clusters_.size() && !check_.after(1); ++c) {
      if (clusters_[c].count > 0 && clusters_[c].changed) {
        expand(c, [this](const Feature& centre, const Feature& voxel) { return distance(centre, voxel); });
      }
    }
    return move_centres();
  }

  /// Layer by layer, gives voxels without owner to the nearest cluster that touches them.
  void reach_the_rest() {
    struct Claim {
      std::uint32_t voxel, cluster;
    };
    std::vector<std::uint32_t> rest;
    check_.for_each(0, owner_.size(), [&](std::size_t v) {
      if (owner_[v] == kNobody) rest.push_back(static_cast<std::uint32_t>(v));
    });
    std::vector<Claim> layer;
    do {
      layer.clear();
      for (const std::uint32_t v : rest) {
        if (check_.after(1 + adjacency_.of(v).size())) return;
        const std::uint32_t c = nearest_neighbouring_cluster(v);
        if (c != kNobody) layer.push_back({v, c});
      }
      check_.for_each(0, layer.size(), [&](std::size_t i) { take(layer[i].cluster, layer[i].voxel, 0); });
      keep_if(rest, [this](std::uint32_t v) { return owner_[v] == kNobody; });
    } while (!layer.empty() && !check_.stopped());
  }

  /// Components that no seed lies in: one cluster each, from the smallest voxel.
  void adopt_components() {
    for (std::uint32_t v = 0; v < owner_.size() && !check_.after(1); ++v) {
      if (owner_[v] != kNobody) continue;
      plant({v});
      if (check_.stopped()) return;
      const auto c = static_cast<std::uint32_t>(clusters_.size() - 1);
      for (std::size_t i = 0; i < clusters_[c].voxels.size(); ++i) {
        const auto neighbors = adjacency_.of(clusters_[c].voxels[i]);
        if (check_.after(1 + neighbors.size())) return;
        for (const std::uint32_t u : neighbors) {
          if (owner_[u] == kNobody) take(c, u, 0);
        }
      }
    }
  }

  Supervoxels numbered() {
    Supervoxels result;
    result.of_voxel.resize(owner_.size());
    std::vector<std::uint32_t> number(clusters_.size(), kNobody);
    check_.for_each(0, owner_.size(), [&](std::size_t v) {
      std::uint32_t& n = number[owner_[v]];
      if (n == kNobody) n = result.count++;
      result.of_voxel[v] = n;
    });
    return result;
  }

 private:
  float distance(const Feature& a, const Feature& b) const {
    const float px = a.px - b.px, py = a.py - b.py, pz = a.pz - b.pz;
    const float cr = a.cr - b.cr, cg = a.cg - b.cg, cb = a.cb - b.cb;
    const float cosine = a.nx * b.nx + a.ny * b.ny + a.nz * b.nz;
    return std::sqrt(px * px + py * py + pz * pz) + std::sqrt(cr * cr + cg * cg + cb * cb) +
           normal_weight_ * (1.0F - std::fabs(cosine));
  }

  /// One turn of a cluster: its centre stays where it is, and what it takes now expands next time.
  template <typename Distance>
  void expand(std::uint32_t c, Distance&& measure) {
    keep_if(clusters_[c].voxels, [&](std::uint32_t v) { return owner_[v] == c; });
    ++turn_;
    const Cluster& cluster = clusters_[c];
    const auto expand_from = [&](std::size_t i) {
      const auto neighbors = adjacency_.of(cluster.voxels[i]);
      for (const std::uint32_t u : neighbors) {
        if (owner_[u] == c || seen_[u] == turn_) continue;
        seen_[u] = turn_;
        const float d = measure(cluster.centre, features_[u]);
        if (d < distance_[u]) take(c, u, d);
      }
      return 1 + neighbors.size();
    };
    check_.for_each(0, cluster.voxels.size(), expand_from);
  }

  template <typename Predicate>
  void keep_if(std::vector<std::uint32_t>& voxels, Predicate&& keep) {
    std::size_t kept = 0;
    const bool complete = check_.for_each(0, voxels.size(), [&](std::size_t i) {
      if (keep(voxels[i])) voxels[kept++] = voxels[i];
    });
    if (complete) voxels.resize(kept);
  }

  void take(std::uint32_t c, std::uint32_t v, float d) {
    if (owner_[v] != kNobody) {
      Cluster& loser = clusters_[owner_[v]];
      --loser.count;
      loser.sum.add(features_[v], -1);
      loser.changed = loser.changed_next = true;
    }
    Cluster& winner = clusters_[c];
    ++winner.count;
    winner.sum.add(features_[v], 1);
    winner.voxels.push_back(v);
    winner.changed_next = true;
    owner_[v] = c;
    distance_[v] = d;
  }

  bool move_centres() {
    bool any = false;
    for (Cluster& cluster : clusters_) {
      if (check_.after(1)) return false;
      any |= cluster.changed_next;
      if (cluster.changed_next && cluster.count > 0) cluster.centre = cluster.sum.mean(cluster.count);
      cluster.changed = cluster.changed_next;
      cluster.changed_next = false;
    }
    return any;
  }

  std::uint32_t nearest_neighbouring_cluster(std::uint32_t v) const {
    std::uint32_t nearest = kNobody;
    float smallest = kUnreached;
    for (const std::uint32_t u : adjacency_.of(v)) {
      const std::uint32_t c = owner_[u];
      if (c == kNobody) continue;
      const float d = distance(clusters_[c].centre, features_[v]);
      if (d < smallest || (d == smallest && c < nearest)) smallest = d, nearest = c;
    }
    return nearest;
  }

  const VoxelAdjacency& adjacency_;
  StopCheck check_;
  float normal_weight_;
  std::vector<Feature> features_;
  std::vector<std::uint32_t> owner_;
  std::vector<float> distance_;      // to the owner's centre when it took the voxel
  std::vector<std::uint32_t> seen_;  // the turn that measured the voxel last
  std::vector<Cluster> clusters_;
  std::uint32_t turn_ = 0;
};

}  // namespace

absl::StatusOr<Supervoxels> grow_supervoxels(const VoxelGrid& grid, const VoxelAdjacency& adjacency,
                                             const std::vector<Vec3>& normals, const Seeds& seeds,
                                             const SupervoxelOptions& options, const StopToken& stop) {
  const auto rounds = static_cast<int>(1.8 * options.seed_resolution / options.voxel_resolution + 1e-6) - 1;
  Growth growth(grid, adjacency, normals, options, stop);
  if (absl::Status status = stop.check(); !status.ok()) return status;
  growth.plant(seeds.chosen);
  growth.first_round();
  for (int round = 1; round < rounds; ++round) {
    if (absl::Status status = stop.check(); !status.ok()) return status;
    if (!growth.round()) break;
  }
  growth.reach_the_rest();
  growth.plant(seeds.sparse);
  growth.reach_the_rest();
  growth.adopt_components();
  if (absl::Status status = stop.check(); !status.ok()) return status;
  Supervoxels supervoxels = growth.numbered();
  if (absl::Status status = stop.check(); !status.ok()) return status;
  return supervoxels;
}

}  // namespace segserve
