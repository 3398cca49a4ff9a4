#include "segserve/metric/paper_metric.hpp"

#include <cmath>

#include "segserve/math/symmetric3.hpp"
#include "segserve/voxel/normals.hpp"

namespace segserve {
namespace {

bool uses_convexity(Method method) { return method == Method::kLambdaConvex || method == Method::kEqualizationConvex; }

Unification learn(const Options& options, std::span<const double> color, std::span<const double> geometry,
                  const StopToken& stop) {
  switch (options.method) {
    case Method::kColor:
      return Unification::fixed(1);
    case Method::kGeometry:
      return Unification::fixed(0);
    case Method::kFixedLambda:
      return Unification::fixed(options.lambda);
    case Method::kLambda:
    case Method::kLambdaConvex:
      return Unification::adaptive(color, geometry, stop);
    case Method::kEqualization:
    case Method::kEqualizationConvex:
      return Unification::equalization(color, geometry, stop);
    case Method::kBorder:
      break;  // has a metric of its own
  }
  return Unification::fixed(options.lambda);
}

}  // namespace

double geometric_term(const Vec3& xi, const Vec3& ni, const Vec3& xj, const Vec3& nj) {
  const Vec3 c = unit(xi - xj);
  // Bracketed so that delta_G(i, j) and delta_G(j, i) are the same bits.
  return (norm(cross(ni, nj)) + (std::fabs(dot(ni, c)) + std::fabs(dot(nj, c)))) / 3;
}

bool is_convex(const Vec3& xi, const Vec3& ni, const Vec3& xj, const Vec3& nj) {
  const Vec3 c = unit(xi - xj);
  return dot(ni, c) - dot(nj, c) >= 0;
}

PaperMetric::PaperMetric(const RegionGraph& graph, const View& view, const Options& options, const StopToken& stop)
    : view_(view),
      convex_(uses_convexity(options.method)),
      min_points_(options.min_segment_points),
      regions_(graph.regions) {
  StopCheck check(stop);
  features_.resize(regions_.size());
  check.for_each(0, regions_.size(), [&](std::size_t r) { features_[r] = features(regions_[r]); });
  std::vector<double> color, geometry;
  check.for_each(0, graph.edges.size(), [&](std::size_t e) {
    const auto& [a, b] = graph.edges[e];
    color.push_back(color_distance(a, b));
    geometry.push_back(geometry_distance(a, b));
  });
  unification_ = learn(options, color, geometry, stop);
}

double PaperMetric::dissimilarity(std::uint32_t i, std::uint32_t j, const Evidence&) const {
  return unification_(color_distance(i, j), geometry_distance(i, j));
}

void PaperMetric::merge(std::uint32_t into, std::uint32_t from) {
  regions_[into].merge(regions_[from]);
  features_[into] = features(regions_[into]);
}

PaperMetric::Features PaperMetric::features(const Region& region) const {
  Vec3 normal = smallest_eigenvector(region.scatter);
  if (normal == Vec3{}) normal = unit(region.normal_sum);  // too few voxels for a plane of its own
  if (view_.has_sensor()) {
    normal = turn_to_sensor(normal, region.centroid, view_);
  } else if (dot(normal, region.normal_sum) < 0) {
    normal = -normal;
  }
  return {normal, srgb_to_lab((1.0 / region.points) * region.color_sum)};
}

double PaperMetric::color_distance(std::uint32_t i, std::uint32_t j) const {
  return ciede2000(features_[i].color, features_[j].color) / kCiede2000Range;
}

double PaperMetric::geometry_distance(std::uint32_t i, std::uint32_t j) const {
  const Vec3 &xi = regions_[i].centroid, &xj = regions_[j].centroid;
  const Vec3 &ni = features_[i].normal, &nj = features_[j].normal;
  const double term = geometric_term(xi, ni, xj, nj);
  return convex_ && is_convex(xi, ni, xj, nj) ? term / 2 : term;
}

}  // namespace segserve
