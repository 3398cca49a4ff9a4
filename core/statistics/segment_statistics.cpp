// SPDX-License-Identifier: Apache-2.0
#include "segserve/segment_statistics.hpp"

#include <algorithm>

#include "core/base/executor.hpp"
#include "core/base/status_macros.hpp"
#include "core/base/stop_check.hpp"
#include "core/math/eigen_conversion.hpp"
#include "core/statistics/principal_axes.hpp"
#include "core/statistics/run_measures.hpp"
#include "core/statistics/segment_sums.hpp"
#include "fmt/format.h"

namespace segserve {
namespace {

/// The points' covariance times a factor, which leaves its axes as they are.
Eigen::Matrix3d covariance(const Moments& m, std::uint32_t points) {
  const auto entry = [points](absl::uint128 product, std::uint64_t a, std::uint64_t b) {
    const auto value = static_cast<absl::int128>(product * points) - static_cast<absl::int128>(absl::uint128{a} * b);
    return static_cast<double>(value);
  };
  const double xy = entry(m.xy, m.x, m.y), xz = entry(m.xz, m.x, m.z), yz = entry(m.yz, m.y, m.z);
  Eigen::Matrix3d matrix;
  matrix << entry(m.xx, m.x, m.x), xy, xz, xy, entry(m.yy, m.y, m.y), yz, xz, yz, entry(m.zz, m.z, m.z);
  return matrix;
}

Eigen::Vector3d mean(std::uint64_t x, std::uint64_t y, std::uint64_t z, std::uint32_t points) {
  const Eigen::Vector3d sum(static_cast<double>(x), static_cast<double>(y), static_cast<double>(z));
  return sum / static_cast<double>(points);
}

void complete_box(const Reach& reach, SegmentStatistics& segment) {
  OrientedBox& box = segment.box;
  box.center = segment.centroid;
  for (std::size_t k = 0; k < 3; ++k) {
    const auto column = static_cast<Eigen::Index>(k);
    box.center += (0.5 * (reach.low[k] + reach.high[k])) * box.axes.col(column);
    box.half_extents[column] = 0.5 * (reach.high[k] - reach.low[k]);
  }
}

absl::Status check_input(const CloudView& cloud, std::span<const std::uint32_t> labels, std::uint32_t segments) {
  RETURN_IF_ERROR(check_shape(cloud));
  if (labels.size() == cloud.size() && segments <= cloud.size()) return absl::OkStatus();
  return absl::InvalidArgumentError(
      fmt::format("{} labels of {} segments for {} points", labels.size(), segments, cloud.size()));
}

absl::Status not_finite(const CloudView& cloud, std::span<const std::uint32_t> labels, std::uint32_t segments) {
  std::size_t i = 0;
  while (is_finite(cloud.x[i], cloud.y[i], cloud.z[i]) || labels[i] == 0 || labels[i] > segments) ++i;
  return absl::InvalidArgumentError(fmt::format("point {} is not finite, but has label {}, not 0", i, labels[i]));
}

}  // namespace

absl::StatusOr<std::vector<SegmentStatistics>> describe_segments(const CloudView& cloud,
                                                                 std::span<const std::uint32_t> labels,
                                                                 std::uint32_t segments, unsigned threads,
                                                                 const StopToken& stop) {
  RETURN_IF_ERROR(check_input(cloud, labels, segments));
  if (segments == 0) return std::vector<SegmentStatistics>();
  Executor executor(threads);
  const SegmentSums sums(labels, segments, executor, stop);
  ASSIGN_OR_RETURN(const std::vector<Bounds> bounds,
                   sums.sum<Bounds>([&](std::uint32_t, std::size_t begin, std::size_t end) {
                     return bounds_of_run(cloud, begin, end);
                   }));
  if (!std::ranges::all_of(bounds, &Bounds::finite)) return not_finite(cloud, labels, segments);

  const std::vector<Grid> grids(bounds.begin(), bounds.end());
  ASSIGN_OR_RETURN(const std::vector<Moments> moments,
                   sums.sum<Moments>([&](std::uint32_t s, std::size_t begin, std::size_t end) {
                     return moments_of_run(cloud, grids[s], begin, end);
                   }));

  std::vector<SegmentStatistics> result(segments);
  StopCheck check(stop);
  check.for_each(0, segments, [&](std::size_t s) {
    const Bounds& b = bounds[s];
    SegmentStatistics& segment = result[s];
    segment.points = b.points;
    if (b.points == 0) return;
    const Moments& m = moments[s];
    segment.centroid = grids[s].meters(mean(m.x, m.y, m.z, b.points));
    segment.box.axes = principal_axes(covariance(m, b.points));
    if (cloud.has_color()) segment.color = mean(b.color[0], b.color[1], b.color[2], b.points);
  });
  RETURN_IF_ERROR(check.status());

  ASSIGN_OR_RETURN(const std::vector<Reach> reach,
                   sums.sum<Reach>([&](std::uint32_t s, std::size_t begin, std::size_t end) {
                     return reach_of_run(cloud, result[s], begin, end);
                   }));
  check.for_each(0, segments, [&](std::size_t s) {
    if (result[s].points > 0) complete_box(reach[s], result[s]);
  });
  RETURN_IF_ERROR(check.status());
  return result;
}

absl::Status set_normals(std::span<const Eigen::Vector3d> supervoxel_normals,
                         std::span<const std::uint32_t> segment_of_leaf, std::span<SegmentStatistics> statistics,
                         const StopToken& stop) {
  constexpr double kNothing = 1e-6;  // unit vectors that cancel out leave a sum of rounding errors
  StopCheck check(stop);
  std::vector<Vec3> sums(statistics.size());
  check.for_each(0, supervoxel_normals.size(), [&](std::size_t leaf) {
    const std::uint32_t s = segment_of_leaf[leaf] - 1;
    if (s < sums.size()) sums[s] += to_vec3(supervoxel_normals[leaf]);
  });
  check.for_each(0, sums.size(), [&](std::size_t s) {
    statistics[s].normal = norm(sums[s]) > kNothing ? std::optional(to_eigen(unit(sums[s]))) : std::nullopt;
  });
  return check.status();
}

}  // namespace segserve
