#include "core/weights/border_metric.hpp"

#include <algorithm>
#include <cmath>

#include "core/base/stop_check.hpp"
#include "core/math/elementary.hpp"
#include "core/weights/simd/weight_kernels.hpp"

namespace segserve {
namespace {

double angle_degrees(const Vec3& a, const Vec3& b) { return math::atan2(norm(cross(a, b)), dot(a, b)) / math::kDegree; }

}  // namespace

bool is_cut(const Vec3& xi, const Vec3& ni, const Vec3& xj, const Vec3& nj, double voxel, double seed) {
  constexpr double kCosine10 = 0.98480775301220806, kCosineOneAndAHalf = 0.99965732497555727;  // of degrees
  constexpr double kClear = 1e-9;  // far beyond rounding errors
  const Vec3 d = xi - xj;
  const Vec3 x = cross(ni, nj);
  const double sine = norm(x);
  // Smoothness: no step between the two surfaces.
  const bool smooth = (std::min(std::fabs(dot(d, ni)), std::fabs(dot(d, nj))) - sine * seed) / voxel <= 0.1;
  if (!smooth) return true;
  const bool flat = dot(ni, nj) > kCosine10 + kClear;
  const bool convex = dot(ni - nj, d) >= 0 || flat || angle_degrees(ni, nj) < 10;
  if (!convex) return true;
  // Sanity: the line between the centroids must not run along the fold. A perfect plane has no fold.
  const double length = norm(d);
  if (sine < 1e-6 || length == 0) return false;
  // The limit is below 60 degrees, and below 1.5 where the angle is below 10: spares most arctangents.
  const double along_cosine = std::fabs(dot(x, d));
  if (along_cosine < ((flat ? kCosineOneAndAHalf : 0.5) - kClear) * (sine * length)) return false;
  const double along = angle_degrees(x, d);
  return std::min(along, 180 - along) < 60 / (1 + math::exp(-0.25 * (angle_degrees(ni, nj) - 25)));
}

std::vector<BorderMetric::Evidence> border_evidence(const RegionGraph& graph, const std::vector<Border>& borders,
                                                    double voxel, double seed, const BorderOptions& options,
                                                    const StopToken& stop) {
  StopCheck check(stop);
  const std::size_t regions = graph.regions.size();
  std::vector<Vec3> normal(regions), rgb(regions);
  std::vector<Lab> color(regions);
  check.for_each_block(0, regions, [&](std::size_t first, std::size_t last) {
    for (std::size_t r = first; r < last; ++r) {
      normal[r] = unit(graph.regions[r].normal_sum);
      rgb[r] = (1.0 / graph.regions[r].points) * graph.regions[r].color_sum;
    }
    metric_kernels().srgb_to_lab(rgb.data() + first, last - first, color.data() + first);
  });
  std::vector<double> difference(graph.edges.size());
  check.for_each_block(0, graph.edges.size(), [&](std::size_t first, std::size_t last) {
    metric_kernels().color_differences(color.data(), graph.edges.data() + first, last - first,
                                       difference.data() + first);
  });
  std::vector<BorderMetric::Evidence> evidence;
  evidence.reserve(graph.edges.size());
  check.for_each(0, graph.edges.size(), [&](std::size_t e) {
    const auto [a, b] = graph.edges[e];
    const bool cut = is_cut(graph.regions[a].centroid, normal[a], graph.regions[b].centroid, normal[b], voxel, seed);
    const double z = (cut ? options.cut_weight : 0) + options.concavity_weight * borders[e].concavity +
                     options.color_weight * difference[e];
    evidence.push_back({borders[e].voxel_pairs, borders[e].voxel_pairs * z});
  });
  return evidence;
}

BorderMetric::BorderMetric(const RegionGraph& graph, std::uint32_t min_points, const BorderOptions& options)
    : options_(options), min_points_(min_points) {
  for (const Region& region : graph.regions) {
    area_.push_back(region.area);
    size_evidence_.push_back(size_evidence(region.area));
    points_.push_back(region.points);
  }
}

double BorderMetric::size_evidence(double area) const {
  const double size = std::max(1.0, std::min(area, options_.size_limit) / options_.size_area);
  constexpr double kLn2 = 0.69314718055994530942;
  return size > 1 ? options_.size_weight * math::ln(size) / kLn2 : 0;
}

double BorderMetric::dissimilarity(std::uint32_t a, std::uint32_t b, const Evidence& evidence) const {
  // Kept for each region: one logarithm a merge instead of one for each of the edges that it changes.
  const double size = area_[a] < area_[b] ? size_evidence_[a] : size_evidence_[b];
  return evidence.weighted / evidence.pairs - options_.bias + size;
}

double BorderMetric::weight(double dissimilarity) const {
  return 1 / (1 + math::exp(-std::clamp(dissimilarity, -700.0, 700.0)));
}

void BorderMetric::merge(std::uint32_t into, std::uint32_t from) {
  area_[into] += area_[from];
  size_evidence_[into] = size_evidence(area_[into]);
  points_[into] += points_[from];
}

}  // namespace segserve
