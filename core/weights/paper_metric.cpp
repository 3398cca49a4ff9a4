// SPDX-License-Identifier: Apache-2.0
#include "core/weights/paper_metric.hpp"

#include <algorithm>
#include <array>

#include "core/base/status_macros.hpp"
#include "core/base/stop_check.hpp"
#include "core/math/symmetric_matrix3.hpp"
#include "core/normals/normal_orientation.hpp"
#include "core/weights/color_difference.hpp"
#include "core/weights/region_metric.hpp"
#include "core/weights/simd/weight_kernels.hpp"

namespace segserve {
namespace {

static_assert(BatchRegionMetric<PaperMetric>);

bool uses_convexity(Method method) { return method == Method::kLambdaConvex || method == Method::kEqualizationConvex; }

absl::StatusOr<ColorGeometryWeight> learn_weight(const FrameContext& frame, std::span<const double> color,
                                                 std::span<const double> geometry) {
  switch (frame.options.method) {
    case Method::kColor:
      return ColorGeometryWeight::fixed(1);
    case Method::kGeometry:
      return ColorGeometryWeight::fixed(0);
    case Method::kLambda:
    case Method::kLambdaConvex:
      return ColorGeometryWeight::adaptive(color, geometry, frame.stop);
    case Method::kEqualization:
    case Method::kEqualizationConvex:
      return ColorGeometryWeight::equalization(color, geometry, frame.stop);
    case Method::kFixedLambda:
    case Method::kBorder:  // It has a metric of its own.
      break;
  }
  return ColorGeometryWeight::fixed(frame.options.lambda);
}

}  // namespace

double geometric_term(const Vec3& xi, const Vec3& ni, const Vec3& xj, const Vec3& nj, bool halve_convex) {
  const Vec3 centroids[] = {xi, xj}, normals[] = {ni, nj};
  const RegionEdge pair{0, 1};
  double term = 0;
  weight_kernels().geometric_terms({centroids, normals}, halve_convex, &pair, 1, &term);
  return term;
}

absl::StatusOr<PaperMetric> PaperMetric::create(const FrameContext& frame, const RegionGraph& graph) {
  PaperMetric metric(frame, graph);
  RETURN_IF_ERROR(metric.learn(frame, graph.edges));
  return metric;
}

PaperMetric::PaperMetric(const FrameContext& frame, const RegionGraph& graph)
    : view_(frame.view()),
      convex_(uses_convexity(frame.options.method)),
      min_points_(frame.options.min_segment_points),
      regions_(graph.regions),
      centroid_(regions_.size()),
      normal_(regions_.size()),
      color_(regions_.size()),
      weight_(ColorGeometryWeight::fixed(frame.options.lambda)) {}

absl::Status PaperMetric::learn(const FrameContext& frame, std::span<const RegionEdge> edges) {
  StopCheck check(frame.stop);
  std::vector<Vec3> rgb(regions_.size());
  check.for_each_block(0, regions_.size(), [&](std::size_t first, std::size_t last) {
    for (std::size_t r = first; r < last; ++r) {
      update_surface(r);
      rgb[r] = (1.0 / regions_[r].points) * regions_[r].color_sum;
    }
    weight_kernels().srgb_to_lab(rgb.data() + first, last - first, color_.data() + first);
  });
  std::vector<double> color(edges.size()), geometry(edges.size());
  check.for_each_block(0, edges.size(), [&](std::size_t first, std::size_t last) {
    const auto pairs = edges.subspan(first, last - first);
    color_distances(pairs, color.data() + first);
    geometry_distances(pairs, geometry.data() + first);
  });
  RETURN_IF_ERROR(check.status());
  ASSIGN_OR_RETURN(weight_, learn_weight(frame, color, geometry));
  initial_.resize(edges.size());
  check.for_each(0, edges.size(), [&](std::size_t e) { initial_[e] = weight_(color[e], geometry[e]); });
  return check.status();
}

double PaperMetric::dissimilarity(std::uint32_t i, std::uint32_t j, const Evidence&) const {
  const RegionEdge pair{i, j};
  double result = 0;
  dissimilarities({&pair, 1}, &result);
  return result;
}

void PaperMetric::dissimilarities(std::span<const RegionEdge> pairs, double* result) const {
  constexpr std::size_t kBlock = 64;
  std::array<double, kBlock> color, geometry;
  for (std::size_t first = 0; first < pairs.size(); first += kBlock) {
    const auto block = pairs.subspan(first, std::min(kBlock, pairs.size() - first));
    color_distances(block, color.data());
    geometry_distances(block, geometry.data());
    for (std::size_t i = 0; i < block.size(); ++i) result[first + i] = weight_(color[i], geometry[i]);
  }
}

void PaperMetric::merge(std::uint32_t into, std::uint32_t from, const Evidence&) {
  regions_[into].merge(regions_[from]);
  update_surface(into);
  color_[into] = srgb_to_lab((1.0 / regions_[into].points) * regions_[into].color_sum);
}

/// Sets the centroid and the normal of region r.
void PaperMetric::update_surface(std::size_t r) {
  const Region& region = regions_[r];
  Vec3 normal = smallest_eigenvector(region.scatter);
  if (normal == Vec3{}) normal = unit(region.normal_sum);  // It has too few voxels for a plane of its own.
  if (view_.has_sensor() && view_.cameras.empty()) {
    normal = turn_to_sensor(normal, region.centroid, sensor_of(view_));
  } else if (dot(normal, region.normal_sum) < 0) {
    normal = -normal;
  }
  centroid_[r] = region.centroid;
  normal_[r] = normal;
}

void PaperMetric::color_distances(std::span<const RegionEdge> pairs, double* result) const {
  weight_kernels().color_differences(color_.data(), pairs.data(), pairs.size(), result);
  for (std::size_t i = 0; i < pairs.size(); ++i) result[i] /= kCiede2000Range;
}

void PaperMetric::geometry_distances(std::span<const RegionEdge> pairs, double* result) const {
  weight_kernels().geometric_terms({centroid_.data(), normal_.data()}, convex_, pairs.data(), pairs.size(), result);
}

}  // namespace segserve
