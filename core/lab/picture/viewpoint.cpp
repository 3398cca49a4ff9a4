// SPDX-License-Identifier: Apache-2.0
#include "core/lab/picture/viewpoint.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <numbers>
#include <span>
#include <utility>

namespace segserve::picture {
namespace {

using Eigen::Vector3d;

/// The middle of a cloud, and the diagonal of its box.
struct Extent {
  Vector3d middle = Vector3d::Zero();
  double size = 0.0;
};

Extent extent_of(const CloudView& cloud, const std::vector<std::uint32_t>& points) {
  std::array<Range, 3> box;
  const std::array<std::span<const float>, 3> planes{cloud.x, cloud.y, cloud.z};
  for (std::size_t axis = 0; axis < 3; ++axis) {
    std::vector<double> values;
    values.reserve(points.size());
    for (const std::uint32_t i : points) values.push_back(planes[axis][i]);
    box[axis] = robust_range(std::move(values));
  }
  return {Vector3d(box[0].middle(), box[1].middle(), box[2].middle()),
          std::hypot(box[0].size(), box[1].size(), box[2].size())};
}

/// A camera at `eye` that looks at `target`, as upright as it can be.
Pinhole look_at(const Vector3d& eye, const Vector3d& target, ViewKind kind) {
  const Vector3d up = kind == ViewKind::kCamera ? Vector3d(0, -1, 0) : Vector3d(0, 0, 1);
  const Vector3d other_up = kind == ViewKind::kCamera ? Vector3d(0, 0, 1) : Vector3d(0, 1, 0);
  Pinhole view;
  view.eye = eye;
  const Vector3d way = target - eye;
  if (way.norm() > 0.0) view.forward = way.normalized();
  constexpr double kAlong = 0.999;  // Looking straight down, no direction in the picture is up.
  view.right = view.forward.cross(std::abs(view.forward.dot(up)) < kAlong ? up : other_up).normalized();
  view.down = view.forward.cross(view.right);
  return view;
}

/// Whether nearly all points are within 50 degrees of where the sensor looks if it looks at the middle.
bool sees_all(const CloudView& cloud, const std::vector<std::uint32_t>& points, const Vector3d& sensor,
              const Vector3d& middle) {
  const Vector3d forward = (middle - sensor).normalized();
  const double least = std::cos(50.0 * std::numbers::pi / 180.0);
  std::size_t seen = 0;
  for (const std::uint32_t i : points) {
    const Vector3d way = Vector3d(cloud.x[i], cloud.y[i], cloud.z[i]) - sensor;
    if (way.dot(forward) >= least * way.norm()) ++seen;
  }
  return static_cast<double>(seen) >= 0.95 * static_cast<double>(points.size());
}

/// Obliquely from above, from the side of the sensor if there is one.
Pinhole oblique_view(const Extent& extent, const std::optional<Eigen::Vector3f>& sensor) {
  double azimuth = -0.3 * std::numbers::pi;
  if (sensor) {
    const Vector3d side = sensor->cast<double>() - extent.middle;
    if (std::hypot(side.x(), side.y()) > 0.05 * extent.size) azimuth = std::atan2(side.y(), side.x());
  }
  constexpr double kElevation = 0.24 * std::numbers::pi;
  const Vector3d back(std::cos(azimuth) * std::cos(kElevation), std::sin(azimuth) * std::cos(kElevation),
                      std::sin(kElevation));
  return look_at(extent.middle + (1.6 * extent.size + 1e-6) * back, extent.middle, ViewKind::kWorld);
}

}  // namespace

Range robust_range(std::vector<double> values) {
  if (values.empty()) return {};
  constexpr std::size_t kOutliers = 1000;  // one value in so many at each end
  const auto cut = static_cast<std::ptrdiff_t>(values.size() / kOutliers);
  std::nth_element(values.begin(), values.begin() + cut, values.end());
  const double low = values[static_cast<std::size_t>(cut)];
  std::nth_element(values.begin(), values.end() - 1 - cut, values.end());
  return {low, values[values.size() - 1 - static_cast<std::size_t>(cut)]};
}

Pinhole choose_viewpoint(const CloudView& cloud, const std::vector<std::uint32_t>& points,
                         const std::optional<Eigen::Vector3f>& view_from) {
  if (!view_from && cloud.view.kind == ViewKind::kCamera) return {};
  const Extent extent = extent_of(cloud, points);
  if (view_from) return look_at(view_from->cast<double>(), extent.middle, cloud.view.kind);
  if (cloud.view.sensor && !points.empty()) {
    const Vector3d sensor = cloud.view.sensor->cast<double>();
    if (sees_all(cloud, points, sensor, extent.middle)) return look_at(sensor, extent.middle, ViewKind::kWorld);
  }
  return oblique_view(extent, cloud.view.sensor);
}

}  // namespace segserve::picture
