#include "segserve/voxel/edge_aware_normals.hpp"

#include <algorithm>

#include "segserve/math/elementary.hpp"
#include "segserve/math/symmetric3.hpp"
#include "segserve/pipeline/parallel.hpp"

namespace segserve {
namespace {

/// Lists the distinct voxels within two steps of a voxel, itself left out.
class TwoRings {
 public:
  explicit TwoRings(const VoxelAdjacency& adjacency) : adjacency_(adjacency), seen_(adjacency.offset.size(), 0) {}

  const std::vector<std::uint32_t>& around(std::uint32_t v) {
    const std::uint32_t mark = v + 1;
    rings_.clear();
    seen_[v] = mark;
    for (const std::uint32_t u : adjacency_.of(v)) add(u, mark);
    const std::size_t first_ring = rings_.size();
    visits_ = 1 + first_ring;
    for (std::size_t i = 0; i < first_ring; ++i) {
      visits_ += adjacency_.of(rings_[i]).size();
      for (const std::uint32_t w : adjacency_.of(rings_[i])) add(w, mark);
    }
    return rings_;
  }
  /// Voxels that the last call of `around` looked at.
  std::size_t visits() const { return visits_; }

 private:
  void add(std::uint32_t u, std::uint32_t mark) {
    if (seen_[u] == mark) return;
    seen_[u] = mark;
    rings_.push_back(u);
  }

  const VoxelAdjacency& adjacency_;
  std::vector<std::uint32_t> seen_;
  std::vector<std::uint32_t> rings_;
  std::size_t visits_ = 0;
};

class Refit {
 public:
  Refit(const VoxelGrid& grid, const std::vector<Vec3>& first, const EdgeAwareOptions& options)
      : grid_(grid), first_(first), options_(options) {
    const double radians = options.angle * math::kDegree;
    angle_scale_ = 2 / (radians * radians);
  }

  /// `voxel`: the edge of a voxel at v, metres.
  Vec3 normal(std::uint32_t v, const std::vector<std::uint32_t>& neighbors, double voxel) {
    weigh(v, neighbors, voxel);
    double total = 1;  // v itself, at the origin
    Vec3 sum;
    Symmetric3 square;
    for (std::size_t i = 0; i < neighbors.size(); ++i) {
      const double w = weight_[i];
      const Vec3 wd = w * offset_[i];
      total += w;
      sum += wd;
      square += {wd.x * offset_[i].x, wd.x * offset_[i].y, wd.x * offset_[i].z,
                 wd.y * offset_[i].y, wd.y * offset_[i].z, wd.z * offset_[i].z};
    }
    if (total <= options_.support) return first_[v];
    square += (-1 / total) * outer(sum);
    const Vec3 refitted = smallest_eigenvector(square);
    if (refitted == Vec3{}) return first_[v];
    return dot(refitted, first_[v]) < 0 ? -refitted : refitted;
  }

 private:
  /// Offsets of the neighbours from v, and their weights. The exponentials are a loop of their own, which
  /// vectorises: they took half of the time.
  void weigh(std::uint32_t v, const std::vector<std::uint32_t>& neighbors, double voxel) {
    const double sigma = options_.offset * voxel;
    const double offset_scale = 1 / (2 * sigma * sigma);
    if (offset_.size() < neighbors.size()) offset_.resize(neighbors.size()), weight_.resize(neighbors.size());
    for (std::size_t i = 0; i < neighbors.size(); ++i) {
      const std::uint32_t u = neighbors[i];
      const Vec3 d = grid_.centroid[u] - grid_.centroid[v];
      const double ov = dot(first_[v], d), ou = dot(first_[u], d);
      // T^2 = 2 (1 - cos T) up to the fourth order.
      const double exponent =
          angle_scale_ * (1 - dot(first_[v], first_[u])) + offset_scale * std::min(ov * ov, ou * ou);
      offset_[i] = d;
      weight_[i] = static_cast<float>(-std::min(exponent, 80.0));
    }
    for (std::size_t i = 0; i < neighbors.size(); ++i) weight_[i] = math::exp(weight_[i]);
  }

  const VoxelGrid& grid_;
  const std::vector<Vec3>& first_;
  const EdgeAwareOptions& options_;
  double angle_scale_;
  std::vector<Vec3> offset_;
  std::vector<float> weight_;
};

}  // namespace

absl::Status refine_normals(const VoxelGrid& grid, const VoxelAdjacency& adjacency, const View& view,
                            double voxel_resolution, const EdgeAwareOptions& options, unsigned threads,
                            const StopToken& stop, std::vector<Vec3>& normals) {
  const std::vector<Vec3> first = normals;
  parallel_ranges(grid.size(), threads, [&](std::size_t begin, std::size_t end) {
    TwoRings rings(adjacency);
    Refit refit(grid, first, options);
    StopCheck check(stop, threads);
    for (std::size_t i = begin; i < end; ++i) {
      const auto v = static_cast<std::uint32_t>(i);
      if (check.after(1)) return;
      if (first[v] == Vec3{}) continue;
      const std::vector<std::uint32_t>& neighbors = rings.around(v);
      if (check.after(rings.visits() + neighbors.size())) return;
      normals[v] = refit.normal(v, neighbors, voxel_edge(voxel_resolution, view, grid.centroid[v]));
    }
  });
  return stop.check();
}

}  // namespace segserve
