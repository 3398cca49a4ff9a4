// SPDX-License-Identifier: Apache-2.0
#include <Eigen/Core>
#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "core/lab/picture/raster.hpp"

namespace segserve::picture {
namespace {

using Eigen::Vector3d;

/// A range of values without outliers at its ends.
struct Range {
  double low = 0.0;
  double high = 0.0;
  double middle() const { return 0.5 * (low + high); }
  double size() const { return high - low; }
};

Range robust_range(std::vector<double> values) {
  if (values.empty()) return {};
  constexpr std::size_t kOutliers = 1000;  // one value in so many at each end
  const auto cut = static_cast<std::ptrdiff_t>(values.size() / kOutliers);
  std::nth_element(values.begin(), values.begin() + cut, values.end());
  const double low = values[static_cast<std::size_t>(cut)];
  std::nth_element(values.begin(), values.end() - 1 - cut, values.end());
  return {low, values[values.size() - 1 - static_cast<std::size_t>(cut)]};
}

std::vector<std::uint32_t> finite_points(const CloudView& cloud) {
  std::vector<std::uint32_t> points;
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    if (is_finite(cloud.x[i], cloud.y[i], cloud.z[i])) points.push_back(static_cast<std::uint32_t>(i));
  }
  return points;
}

/// A pinhole camera: its position and its axes in the frame of the cloud.
struct Pinhole {
  Vector3d eye = Vector3d::Zero();
  Vector3d right = Vector3d::UnitX();
  Vector3d down = Vector3d::UnitY();
  Vector3d forward = Vector3d::UnitZ();
};

/// Looks at the middle of the cloud obliquely from above, from the side of the sensor if there is one.
Pinhole oblique_view(const CloudView& cloud, const std::vector<std::uint32_t>& points) {
  std::array<Range, 3> box;
  const std::array<std::span<const float>, 3> planes{cloud.x, cloud.y, cloud.z};
  for (std::size_t axis = 0; axis < 3; ++axis) {
    std::vector<double> values;
    values.reserve(points.size());
    for (const std::uint32_t i : points) values.push_back(planes[axis][i]);
    box[axis] = robust_range(std::move(values));
  }
  const Vector3d middle(box[0].middle(), box[1].middle(), box[2].middle());
  const double size = std::hypot(box[0].size(), box[1].size(), box[2].size());
  double azimuth = -0.3 * std::numbers::pi;
  if (cloud.view.sensor) {
    const Vector3d side = cloud.view.sensor->cast<double>() - middle;
    if (std::hypot(side.x(), side.y()) > 0.05 * size) azimuth = std::atan2(side.y(), side.x());
  }
  constexpr double kElevation = 0.24 * std::numbers::pi;
  const Vector3d back(std::cos(azimuth) * std::cos(kElevation), std::sin(azimuth) * std::cos(kElevation),
                      std::sin(kElevation));
  Pinhole view;
  view.eye = middle + (1.6 * size + 1e-6) * back;
  view.forward = -back;
  view.right = Vector3d(-std::sin(azimuth), std::cos(azimuth), 0.0);
  view.down = view.forward.cross(view.right);
  return view;
}

/// A point as the pinhole camera sees it: tangents to the right and down, and depth.
struct ProjectedPoint {
  std::uint32_t point = 0;
  double u = 0.0;
  double v = 0.0;
  double depth = 0.0;
};

std::vector<ProjectedPoint> project(const CloudView& cloud, const std::vector<std::uint32_t>& points,
                                    const Pinhole& view) {
  std::vector<ProjectedPoint> projected;
  projected.reserve(points.size());
  for (const std::uint32_t i : points) {
    const Vector3d p = Vector3d(cloud.x[i], cloud.y[i], cloud.z[i]) - view.eye;
    const double depth = p.dot(view.forward);
    if (depth > 0.0) projected.push_back({i, p.dot(view.right) / depth, p.dot(view.down) / depth, depth});
  }
  return projected;
}

/// Scale and shift from tangents to pixels, so that the cloud fills the picture except for a margin.
struct Framing {
  double scale = 1.0;
  double u = 0.0;  ///< Tangents in the middle of the picture.
  double v = 0.0;
  double covered = 1.0;  ///< Share of the picture that the extent of the cloud covers.
};

Framing frame(const std::vector<ProjectedPoint>& projected, std::uint32_t width, std::uint32_t height) {
  std::vector<double> us, vs;
  for (const ProjectedPoint& s : projected) {
    us.push_back(s.u);
    vs.push_back(s.v);
  }
  const Range u = robust_range(std::move(us));
  const Range v = robust_range(std::move(vs));
  constexpr double kFilled = 0.88;
  constexpr double kLeast = 1e-9;  // for clouds whose points are all in a line, or at one place
  const double scale = kFilled * std::min(width / std::max(u.size(), kLeast), height / std::max(v.size(), kLeast));
  const double covered = (scale * u.size() / width) * (scale * v.size() / height);
  return {scale, u.middle(), v.middle(), std::clamp(covered, 0.02, 1.0)};
}

/// Half the side, in pixels, of the square that a point covers, so that surfaces have no gaps.
int splat_radius(const Framing& framing, const Raster& raster, std::size_t points) {
  const double pixels_per_point =
      framing.covered * raster.width * raster.height / static_cast<double>(std::max<std::size_t>(points, 1));
  return static_cast<int>(std::clamp(std::floor(0.9 * std::sqrt(pixels_per_point)), 1.0, 12.0));
}

void splat(const ProjectedPoint& point, double px, double py, int radius, Raster& raster) {
  const auto left = static_cast<int>(std::floor(px)) - radius;
  const auto top = static_cast<int>(std::floor(py)) - radius;
  const auto depth = static_cast<float>(point.depth);
  for (int y = std::max(top, 0); y <= std::min(top + 2 * radius, static_cast<int>(raster.height) - 1); ++y) {
    for (int x = std::max(left, 0); x <= std::min(left + 2 * radius, static_cast<int>(raster.width) - 1); ++x) {
      const std::size_t pixel = static_cast<std::size_t>(y) * raster.width + static_cast<std::size_t>(x);
      if (raster.point[pixel] != Raster::kNoPoint && raster.depth[pixel] <= depth) continue;
      raster.point[pixel] = point.point;
      raster.depth[pixel] = depth;
    }
  }
}

}  // namespace

Raster rasterize_projected(const CloudView& cloud, std::uint32_t width, std::uint32_t height) {
  Raster raster(width, height);
  const std::vector<std::uint32_t> points = finite_points(cloud);
  const Pinhole view = cloud.view.kind == ViewKind::kCamera ? Pinhole{} : oblique_view(cloud, points);
  const std::vector<ProjectedPoint> projected = project(cloud, points, view);
  const Framing framing = frame(projected, width, height);
  const int radius = splat_radius(framing, raster, projected.size());
  for (const ProjectedPoint& point : projected) {
    const double px = 0.5 * width + framing.scale * (point.u - framing.u);
    const double py = 0.5 * height + framing.scale * (point.v - framing.v);
    const bool near_picture = std::abs(px) < 2.0 * width && std::abs(py) < 2.0 * height;
    if (near_picture) splat(point, px, py, radius, raster);
  }
  return raster;
}

}  // namespace segserve::picture
