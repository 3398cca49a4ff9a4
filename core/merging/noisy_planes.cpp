// SPDX-License-Identifier: Apache-2.0
#include "core/merging/noisy_planes.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <functional>
#include <numeric>
#include <optional>
#include <vector>

#include "core/base/stop_check.hpp"

namespace segserve {
namespace {

/// A plane explains voxels if they deviate from it by so many standard deviations of the noise, in the mean.
/// Neighboring errors of a camera are alike, which the estimate of the noise does not see.
constexpr double kMostDeviation = 3;
constexpr double kFewestVoxels = 100;  // of the segment from which a plane grows

/// 1/z = a x/z + b y/z + c
struct Plane {
  double a = 0, b = 0, c = 0;
};

/// Sums over voxels at (u, v) = (x/z, y/z) with w = 1/z.
class Moments {
 public:
  void add(double pu, double pv, double pw) {
    n_ += 1, u_ += pu, v_ += pv, w_ += pw;
    uu_ += pu * pu, uv_ += pu * pv, vv_ += pv * pv, uw_ += pu * pw, vw_ += pv * pw, ww_ += pw * pw;
  }
  void add(const Moments& o) {
    n_ += o.n_, u_ += o.u_, v_ += o.v_, w_ += o.w_;
    uu_ += o.uu_, uv_ += o.uv_, vv_ += o.vv_, uw_ += o.uw_, vw_ += o.vw_, ww_ += o.ww_;
  }

  double voxels() const { return n_; }

  /// The plane of least squares; nullopt where the voxels do not span one.
  std::optional<Plane> plane() const {
    if (n_ < 3) return std::nullopt;
    const double cuu = uu_ - u_ * u_ / n_, cuv = uv_ - u_ * v_ / n_, cvv = vv_ - v_ * v_ / n_;
    const double cuw = uw_ - u_ * w_ / n_, cvw = vw_ - v_ * w_ / n_;
    const double determinant = cuu * cvv - cuv * cuv;
    if (!(determinant > 1e-6 * cuu * cvv)) return std::nullopt;
    const double a = (cuw * cvv - cvw * cuv) / determinant, b = (cvw * cuu - cuw * cuv) / determinant;
    return Plane{a, b, (w_ - a * u_ - b * v_) / n_};
  }

  /// Root mean square of w about a plane.
  double deviation(const Plane& p) const {
    const double squares = ww_ + p.a * p.a * uu_ + p.b * p.b * vv_ + n_ * p.c * p.c - 2 * p.a * uw_ - 2 * p.b * vw_ -
                           2 * p.c * w_ + 2 * p.a * p.b * uv_ + 2 * p.a * p.c * u_ + 2 * p.b * p.c * v_;
    return std::sqrt(std::max(0.0, squares / n_));
  }

 private:
  double n_ = 0, u_ = 0, v_ = 0, w_ = 0, uu_ = 0, uv_ = 0, vv_ = 0, uw_ = 0, vw_ = 0, ww_ = 0;
};

bool is_noisy(const FrameContext& frame, const RegionGraph& graph, std::uint32_t region) {
  return graph.regions[region].centroid.z > frame.scale.noise_depth;
}

/// The segments of a first cut, as far as they lie where noise exceeds a voxel.
class NoisySegments {
 public:
  NoisySegments(const FrameContext& frame, const RegionGraph& graph, const Cut& cut, StopCheck& check)
      : frame_(frame),
        graph_(graph),
        segment_of_(cut.segment_of_leaf),
        check_(check),
        moments_(cut.segments + 1),
        neighbors_(cut.segments + 1),
        plane_of_(cut.segments + 1) {}

  void gather(const VoxelGrid& grid, const Supervoxels& supervoxels) {
    check_.for_each(0, grid.size(), [&](std::size_t v) {
      const std::uint32_t region = supervoxels.supervoxel_of_voxel[v];
      if (!is_noisy(frame_, graph_, region)) return;
      const Vec3& p = grid.centroid[v];
      moments_[segment_of_[region]].add(p.x / p.z, p.y / p.z, 1 / p.z);
    });
    check_.for_each(0, graph_.edges.size(), [&](std::size_t e) {
      const auto [a, b] = graph_.edges[e];
      const std::uint32_t first = segment_of_[a], second = segment_of_[b];
      if (first == second || !is_noisy(frame_, graph_, a) || !is_noisy(frame_, graph_, b)) return;
      neighbors_[first].push_back(second), neighbors_[second].push_back(first);
    });
    for (auto& neighbors : neighbors_) std::ranges::sort(neighbors);
  }

  /// Returns whether any plane has several segments.
  bool grow_planes() {
    std::vector<std::uint32_t> order(moments_.size() - 1);
    std::iota(order.begin(), order.end(), 1U);
    std::ranges::stable_sort(order, std::greater(), [&](std::uint32_t s) { return moments_[s].voxels(); });
    bool has_grown = false;
    for (const std::uint32_t seed : order) {
      if (check_.after(1) || moments_[seed].voxels() < kFewestVoxels) break;
      if (plane_of_[seed] == 0) has_grown |= grow_from(seed);
    }
    return has_grown;
  }

  /// Whether an edge lies within a plane that has grown.
  bool is_within_plane(const RegionEdge& edge) const {
    const std::uint32_t plane = plane_of_[segment_of_[edge.a]];
    return plane != 0 && plane == plane_of_[segment_of_[edge.b]] && is_noisy(frame_, graph_, edge.a) &&
           is_noisy(frame_, graph_, edge.b);
  }

 private:
  bool grow_from(std::uint32_t seed) {
    Moments sum = moments_[seed];
    const auto first = sum.plane();
    if (!first || !explains(*first, sum)) return false;
    plane_of_[seed] = seed;
    std::vector<std::uint32_t> reached{seed};
    for (std::size_t i = 0; i < reached.size(); ++i) {
      for (const std::uint32_t other : neighbors_[reached[i]]) {
        if (check_.after(1) || plane_of_[other] != 0) continue;
        Moments both = sum;
        both.add(moments_[other]);
        const auto plane = both.plane();
        if (!plane || !explains(*plane, moments_[other]) || !explains(*plane, both)) continue;
        sum = both;
        plane_of_[other] = seed;
        reached.push_back(other);
      }
    }
    return reached.size() > 1;
  }

  bool explains(const Plane& plane, const Moments& moments) const {
    return moments.deviation(plane) <= kMostDeviation * frame_.scale.noise();
  }

  const FrameContext& frame_;
  const RegionGraph& graph_;
  const std::vector<std::uint32_t>& segment_of_;  // of each region, from 1 on
  StopCheck& check_;
  std::vector<Moments> moments_;                       // of each segment
  std::vector<std::vector<std::uint32_t>> neighbors_;  // likewise
  std::vector<std::uint32_t> plane_of_;                // the segment from which its plane has grown; 0: none
};

}  // namespace

bool has_noisy_regions(const FrameContext& frame, const RegionGraph& graph) {
  if (frame.view().kind != ViewKind::kCamera) return false;
  return std::ranges::any_of(graph.regions, [&](const Region& r) { return r.centroid.z > frame.scale.noise_depth; });
}

absl::StatusOr<bool> forgive_noisy_planes(const FrameContext& frame, const VoxelGrid& grid,
                                          const Supervoxels& supervoxels, const RegionGraph& graph, const Cut& cut,
                                          std::vector<BorderEvidence>& evidence) {
  StopCheck check(frame.stop);
  NoisySegments segments(frame, graph, cut, check);
  segments.gather(grid, supervoxels);
  const bool has_grown = segments.grow_planes();
  check.for_each(0, has_grown ? graph.edges.size() : 0, [&](std::size_t e) {
    if (segments.is_within_plane(graph.edges[e])) evidence[e].sum = 0;
  });
  if (check.stopped()) return check.status();
  return has_grown;
}

}  // namespace segserve
