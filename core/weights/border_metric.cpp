// SPDX-License-Identifier: Apache-2.0
#include "core/weights/border_metric.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "core/base/stop_check.hpp"
#include "core/math/elementary.hpp"
#include "core/voxels/voxel_grid.hpp"
#include "core/weights/region_metric.hpp"
#include "core/weights/simd/weight_kernels.hpp"

namespace segserve {
namespace {

static_assert(PartialRegionMetric<BorderMetric>);

/// The tolerance for supervoxels at this depth (depth_of), meters.
SurfaceTolerance tolerance_at(const VoxelScale& scale, const BorderConstants& constants, double depth) {
  constexpr double kHighestStep = 0.1, kFlat = 10;  // of a voxel; degrees
  const double unit = scale.in_proportion ? depth : 1, noise = scale.excess_noise(depth);
  return {kHighestStep * (1 + constants.noise_step * noise) * unit * scale.voxel, unit * scale.seed,
          kFlat + constants.noise_angle * noise};
}

double angle_degrees(const Vec3& a, const Vec3& b) { return math::atan2(norm(cross(a, b)), dot(a, b)) / math::kDegree; }

}  // namespace

bool is_cut(const Vec3& xi, const Vec3& ni, const Vec3& xj, const Vec3& nj, const SurfaceTolerance& tolerance) {
  constexpr double kCosine10 = 0.98480775301220806, kCosineOneAndAHalf = 0.99965732497555727;  // of degrees
  constexpr double kMargin = 1e-9;  // far larger than rounding errors
  const Vec3 d = xi - xj;
  const Vec3 fold = cross(ni, nj);
  const double sine = norm(fold);
  // Smoothness: there is no step between the two surfaces.
  const double step = std::min(std::fabs(dot(d, ni)), std::fabs(dot(d, nj))) - sine * tolerance.seed;
  if (!(step <= tolerance.step)) return true;
  const bool flat = dot(ni, nj) > kCosine10 + kMargin;
  const bool convex = dot(ni - nj, d) >= 0 || flat || angle_degrees(ni, nj) < tolerance.angle;
  if (!convex) return true;
  // Sanity: the line between the centroids must not run along the fold. A perfect plane has no fold.
  const double length = norm(d);
  if (sine < 1e-6 || length == 0) return false;
  // The limit is below 60 degrees, and below 1.5 where the normals are less than 10 apart. So most arctangents are not
  // needed.
  const double along_cosine = std::fabs(dot(fold, d));
  if (along_cosine < ((flat ? kCosineOneAndAHalf : 0.5) - kMargin) * (sine * length)) return false;
  const double along = angle_degrees(fold, d);
  return std::min(along, 180 - along) < 60 / (1 + math::exp(-0.25 * (angle_degrees(ni, nj) - 25)));
}

absl::Status find_border_evidence(const FrameContext& frame, const RegionGraph& graph,
                                  const std::vector<Border>& borders, const BorderConstants& constants,
                                  std::vector<BorderEvidence>& evidence) {
  StopCheck check(frame.stop);
  const std::size_t regions = graph.regions.size();
  std::vector<Vec3> normal(regions), rgb(regions);
  std::vector<Lab> color(regions);
  check.for_each_block(0, regions, [&](std::size_t first, std::size_t last) {
    for (std::size_t r = first; r < last; ++r) {
      normal[r] = unit(graph.regions[r].normal_sum);
      rgb[r] = (1.0 / graph.regions[r].points) * graph.regions[r].color_sum;
    }
    weight_kernels().srgb_to_lab(rgb.data() + first, last - first, color.data() + first);
  });
  std::vector<double> difference(graph.edges.size());
  check.for_each_block(0, graph.edges.size(), [&](std::size_t first, std::size_t last) {
    weight_kernels().color_differences(color.data(), graph.edges.data() + first, last - first,
                                       difference.data() + first);
  });
  evidence.resize(graph.edges.size());
  check.for_each(0, graph.edges.size(), [&](std::size_t e) {
    const auto [a, b] = graph.edges[e];
    const Region &ra = graph.regions[a], &rb = graph.regions[b];
    const double depth = 0.5 * (depth_of(frame.scale, ra.centroid) + depth_of(frame.scale, rb.centroid));
    const bool cut =
        is_cut(ra.centroid, normal[a], rb.centroid, normal[b], tolerance_at(frame.scale, constants, depth));
    const double z = (cut ? constants.cut_weight : 0) + constants.concavity_weight * borders[e].concavity +
                     constants.color_weight * difference[e];
    evidence[e] = {borders[e].contacts, borders[e].contacts * z};
  });
  return check.status();
}

BorderMetric::BorderMetric(const RegionGraph& graph, std::vector<BorderEvidence> evidence, std::uint32_t min_points,
                           const BorderConstants& constants)
    : constants_(constants), min_points_(min_points), evidence_(std::move(evidence)) {
  for (const Region& region : graph.regions) {
    wall_size_ += constants.wall_share * region.voxels;
    voxels_.push_back(region.voxels);
    normal_sum_.push_back(region.normal_sum);
    size_term_.push_back(size_term(region.voxels));
    points_.push_back(region.points);
  }
  contacts_.resize(voxels_.size());
  for (std::size_t e = 0; e < evidence_.size(); ++e) {
    contacts_[graph.edges[e].a] += evidence_[e].contacts;
    contacts_[graph.edges[e].b] += evidence_[e].contacts;
  }
  for (std::size_t r = 0; r < voxels_.size(); ++r) {
    is_chip_.push_back(is_chip(voxels_[r], contacts_[r]) ? 1 : 0);
    is_wall_.push_back(is_wall(voxels_[r], normal_sum_[r]) ? 1 : 0);
  }
}

bool BorderMetric::is_chip(double voxels, double contacts) const {
  return voxels < constants_.smallest_size || contacts > constants_.chip_contacts * voxels;
}

bool BorderMetric::is_wall(double voxels, const Vec3& normal_sum) const {
  if (constants_.wall_weight == 1) return false;  // Nothing depends on it, so no edges change.
  return voxels >= wall_size_ && norm(normal_sum) >= constants_.wall_flatness * voxels;
}

bool BorderMetric::becomes_wall(std::uint32_t into, std::uint32_t from) const {
  return is_wall_[from] != 0 || is_wall(voxels_[into] + voxels_[from], normal_sum_[into] + normal_sum_[from]);
}

double BorderMetric::size_term(double voxels) const {
  const double size = std::max(1.0, std::min(voxels, constants_.size_limit) / constants_.size);
  constexpr double kLn2 = 0.69314718055994530942;
  return size > 1 ? constants_.size_weight * math::ln(size) / kLn2 : 0;
}

double BorderMetric::dissimilarity(std::uint32_t a, std::uint32_t b, const BorderEvidence& evidence) const {
  const double size = voxels_[a] < voxels_[b] ? size_term_[a] : size_term_[b];
  const double weight = (is_wall_[a] | is_wall_[b]) != 0 ? constants_.wall_weight : 1;
  return weight * (evidence.sum / evidence.contacts) - constants_.bias + size;
}

double BorderMetric::weight(double dissimilarity) const {
  return 1 / (1 + math::exp(-std::clamp(dissimilarity, -700.0, 700.0)));
}

void BorderMetric::merge(std::uint32_t into, std::uint32_t from, const BorderEvidence& between) {
  is_wall_[into] = is_wall_[into] != 0 || becomes_wall(into, from) ? 1 : 0;
  voxels_[into] += voxels_[from];
  normal_sum_[into] += normal_sum_[from];
  contacts_[into] += contacts_[from] - 2 * between.contacts;
  is_chip_[into] = is_chip_[into] != 0 && is_chip_[from] != 0 && is_chip(voxels_[into], contacts_[into]) ? 1 : 0;
  size_term_[into] = size_term(voxels_[into]);
  points_[into] += points_[from];
}

}  // namespace segserve
