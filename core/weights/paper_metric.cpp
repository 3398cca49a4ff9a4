#include "core/weights/paper_metric.hpp"

#include <algorithm>
#include <array>

#include "core/base/stop_check.hpp"
#include "core/math/symmetric_matrix3.hpp"
#include "core/normals/normal_orientation.hpp"
#include "core/weights/simd/weight_kernels.hpp"

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

double geometric_term(const Vec3& xi, const Vec3& ni, const Vec3& xj, const Vec3& nj, bool halve_convex) {
  const Vec3 centroids[] = {xi, xj}, normals[] = {ni, nj};
  const RegionEdge pair{0, 1};
  double term = 0;
  metric_kernels().geometric_terms({centroids, normals}, halve_convex, &pair, 1, &term);
  return term;
}

PaperMetric::PaperMetric(const RegionGraph& graph, const View& view, const Options& options, const StopToken& stop)
    : view_(view),
      convex_(uses_convexity(options.method)),
      min_points_(options.min_segment_points),
      regions_(graph.regions),
      centroid_(regions_.size()),
      normal_(regions_.size()),
      color_(regions_.size()) {
  StopCheck check(stop);
  std::vector<Vec3> rgb(regions_.size());
  check.for_each_block(0, regions_.size(), [&](std::size_t first, std::size_t last) {
    for (std::size_t r = first; r < last; ++r) {
      find_surface(r);
      rgb[r] = (1.0 / regions_[r].points) * regions_[r].color_sum;
    }
    metric_kernels().srgb_to_lab(rgb.data() + first, last - first, color_.data() + first);
  });
  std::vector<double> color(graph.edges.size()), geometry(graph.edges.size());
  check.for_each_block(0, graph.edges.size(), [&](std::size_t first, std::size_t last) {
    const auto pairs = std::span(graph.edges).subspan(first, last - first);
    color_distances(pairs, color.data() + first);
    geometry_distances(pairs, geometry.data() + first);
  });
  unification_ = learn(options, color, geometry, stop);
  initial_.resize(graph.edges.size());
  check.for_each(0, initial_.size(), [&](std::size_t e) { initial_[e] = unification_(color[e], geometry[e]); });
}

double PaperMetric::dissimilarity(std::uint32_t i, std::uint32_t j, const Evidence&) const {
  const RegionEdge pair{i, j};
  double result = 0;
  dissimilarities({&pair, 1}, &result);
  return result;
}

void PaperMetric::dissimilarities(std::span<const RegionEdge> pairs, double* result) const {
  constexpr std::size_t kTogether = 64;
  std::array<double, kTogether> color, geometry;
  for (std::size_t first = 0; first < pairs.size(); first += kTogether) {
    const auto some = pairs.subspan(first, std::min(kTogether, pairs.size() - first));
    color_distances(some, color.data());
    geometry_distances(some, geometry.data());
    for (std::size_t i = 0; i < some.size(); ++i) result[first + i] = unification_(color[i], geometry[i]);
  }
}

void PaperMetric::merge(std::uint32_t into, std::uint32_t from) {
  regions_[into].merge(regions_[from]);
  find_surface(into);
  color_[into] = srgb_to_lab((1.0 / regions_[into].points) * regions_[into].color_sum);
}

void PaperMetric::find_surface(std::size_t r) {
  const Region& region = regions_[r];
  Vec3 normal = smallest_eigenvector(region.scatter);
  if (normal == Vec3{}) normal = unit(region.normal_sum);  // too few voxels for a plane of its own
  if (view_.has_sensor()) {
    normal = turn_to_sensor(normal, region.centroid, sensor_of(view_));
  } else if (dot(normal, region.normal_sum) < 0) {
    normal = -normal;
  }
  centroid_[r] = region.centroid;
  normal_[r] = normal;
}

void PaperMetric::color_distances(std::span<const RegionEdge> pairs, double* result) const {
  metric_kernels().color_differences(color_.data(), pairs.data(), pairs.size(), result);
  for (std::size_t i = 0; i < pairs.size(); ++i) result[i] /= kCiede2000Range;
}

void PaperMetric::geometry_distances(std::span<const RegionEdge> pairs, double* result) const {
  metric_kernels().geometric_terms({centroid_.data(), normal_.data()}, convex_, pairs.data(), pairs.size(), result);
}

}  // namespace segserve
