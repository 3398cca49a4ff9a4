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
    for (std::size_t i = 0; i < first_ring; ++i) {
      for (const std::uint32_t w : adjacency_.of(rings_[i])) add(w, mark);
    }
    return rings_;
  }

 private:
  void add(std::uint32_t u, std::uint32_t mark) {
    if (seen_[u] == mark) return;
    seen_[u] = mark;
    rings_.push_back(u);
  }

  const VoxelAdjacency& adjacency_;
  std::vector<std::uint32_t> seen_;
  std::vector<std::uint32_t> rings_;
};

class Refit {
 public:
  Refit(const VoxelGrid& grid, const std::vector<Vec3>& first, const EdgeAwareOptions& options)
      : grid_(grid), first_(first), options_(options) {
    const double radians = options.angle * math::kDegree;
    angle_scale_ = 2 / (radians * radians);
  }

  /// `voxel`: the edge of a voxel at v, metres.
  Vec3 normal(std::uint32_t v, const std::vector<std::uint32_t>& neighbors, double voxel) const {
    const Vec3& xv = grid_.centroid[v];
    const Vec3& nv = first_[v];
    const double sigma = options_.offset * voxel;
    const double offset_scale = 1 / (2 * sigma * sigma);
    double weights = 1;  // of v itself, at the origin
    Vec3 sum;
    Symmetric3 square;
    for (const std::uint32_t u : neighbors) {
      const Vec3 d = grid_.centroid[u] - xv;
      const double ov = dot(nv, d), ou = dot(first_[u], d);
      // T^2 = 2 (1 - cos T) up to the fourth order.
      const double exponent =
          angle_scale_ * (1 - dot(nv, first_[u])) + offset_scale * std::min(ov * ov, ou * ou);
      if (exponent > kNegligible) continue;
      const double w = math::exp(-exponent);
      weights += w;
      sum += w * d;
      square += w * outer(d);
    }
    if (weights <= options_.support) return nv;
    square += (-1 / weights) * outer(sum);
    const Vec3 refitted = smallest_eigenvector(square);
    if (refitted == Vec3{}) return nv;
    return dot(refitted, nv) < 0 ? -refitted : refitted;
  }

 private:
  static constexpr double kNegligible = 16;  // a weight of 1e-7

  const VoxelGrid& grid_;
  const std::vector<Vec3>& first_;
  const EdgeAwareOptions& options_;
  double angle_scale_;
};

}  // namespace

absl::Status refine_normals(const VoxelGrid& grid, const VoxelAdjacency& adjacency, const View& view,
                            double voxel_resolution, const EdgeAwareOptions& options, unsigned threads,
                            const StopToken& stop, std::vector<Vec3>& normals) {
  constexpr std::size_t kStopInterval = 2048;
  const std::vector<Vec3> first = normals;
  const Refit refit(grid, first, options);
  parallel_ranges(grid.size(), threads, [&](std::size_t begin, std::size_t end) {
    TwoRings rings(adjacency);
    for (std::size_t i = begin; i < end; ++i) {
      if ((i - begin) % kStopInterval == 0 && stop.stopped()) return;
      const auto v = static_cast<std::uint32_t>(i);
      if (first[v] == Vec3{}) continue;
      const double voxel = view.kind == ViewKind::kCamera ? voxel_resolution * grid.centroid[v].z : voxel_resolution;
      normals[v] = refit.normal(v, rings.around(v), voxel);
    }
  });
  return stop.check();
}

}  // namespace segserve
