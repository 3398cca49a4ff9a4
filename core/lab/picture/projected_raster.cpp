// SPDX-License-Identifier: Apache-2.0
#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <utility>

#include "core/lab/picture/raster.hpp"
#include "core/lab/picture/viewpoint.hpp"

namespace segserve::picture {
namespace {

using Eigen::Vector3d;

std::vector<std::uint32_t> finite_points(const CloudView& cloud) {
  const bool is_camera = cloud.view.kind == ViewKind::kCamera;
  std::vector<std::uint32_t> points;
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    const bool is_measured = !is_camera || cloud.x[i] != 0.0F || cloud.y[i] != 0.0F || cloud.z[i] != 0.0F;
    if (is_measured && is_finite(cloud.x[i], cloud.y[i], cloud.z[i])) points.push_back(static_cast<std::uint32_t>(i));
  }
  return points;
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
};

/// A viewer amid the cloud cannot show what is at its sides: the picture ends at an angle.
Range visible(Range range) {
  constexpr double kWidest = 1.2;  // the tangent of 50 degrees
  return {std::clamp(range.low, -kWidest, kWidest), std::clamp(range.high, -kWidest, kWidest)};
}

Framing frame(const std::vector<ProjectedPoint>& projected, std::uint32_t width, std::uint32_t height) {
  std::vector<double> us, vs;
  for (const ProjectedPoint& s : projected) {
    us.push_back(s.u);
    vs.push_back(s.v);
  }
  const Range u = visible(robust_range(std::move(us)));
  const Range v = visible(robust_range(std::move(vs)));
  constexpr double kFilled = 0.88;
  constexpr double kLeast = 1e-9;  // for clouds whose points are all in a line, or at one place
  const double scale = kFilled * std::min(width / std::max(u.size(), kLeast), height / std::max(v.size(), kLeast));
  return {scale, u.middle(), v.middle()};
}

/// A point's place in the picture, in pixels from its upper left corner.
struct Place {
  double x = 0.0;
  double y = 0.0;
};

/// How many points fall into each square of the picture. It decides how large points are drawn, so that surfaces have
/// no gaps where they are far away or seldom measured, and are sharp elsewhere.
class PointDensity {
 public:
  PointDensity(std::uint32_t width, std::uint32_t height)
      : columns_(width / kSide + 3), rows_(height / kSide + 3), count_(columns_ * rows_) {}

  void add(const Place& place) { count_[cell(place)] += 1.0; }

  /// Half the side, in pixels, of the square that a point covers there.
  int radius(const Place& place) const {
    const std::size_t middle = cell(place);
    const std::size_t column = middle % columns_;
    const std::size_t row = middle / columns_;
    double points = 0.0;
    double squares = 0.0;
    for (std::size_t y = std::max<std::size_t>(row, 1) - 1; y <= std::min(row + 1, rows_ - 1); ++y) {
      for (std::size_t x = std::max<std::size_t>(column, 1) - 1; x <= std::min(column + 1, columns_ - 1); ++x) {
        const double count = count_[y * columns_ + x];
        if (count == 0.0) continue;  // It lies beyond the edge of the surface.
        points += count;
        squares += 1.0;
      }
    }
    const double pixels_per_point = squares * kSide * kSide / std::max(points, 1.0);
    constexpr double kLargest = 9.0;
    return static_cast<int>(std::clamp(std::floor(0.75 * std::sqrt(pixels_per_point)), 1.0, kLargest));
  }

 private:
  static constexpr std::uint32_t kSide = 24;

  std::size_t cell(const Place& place) const {
    const auto index = [](double v, std::size_t count) {
      return static_cast<std::size_t>(std::clamp(std::floor(v / kSide) + 1.0, 0.0, static_cast<double>(count - 1)));
    };
    return index(place.y, rows_) * columns_ + index(place.x, columns_);
  }

  std::size_t columns_, rows_;
  std::vector<double> count_;
};

/// Draws a point as a disk.
void splat(const ProjectedPoint& point, const Place& place, int radius, Raster& raster) {
  const auto middle_x = static_cast<int>(std::floor(place.x));
  const auto middle_y = static_cast<int>(std::floor(place.y));
  const auto depth = static_cast<float>(point.depth);
  const int bottom = std::min(middle_y + radius, static_cast<int>(raster.height) - 1);
  const int right = std::min(middle_x + radius, static_cast<int>(raster.width) - 1);
  for (int y = std::max(middle_y - radius, 0); y <= bottom; ++y) {
    for (int x = std::max(middle_x - radius, 0); x <= right; ++x) {
      const int dx = x - middle_x;
      const int dy = y - middle_y;
      if (radius > 1 && dx * dx + dy * dy > radius * (radius + 1)) continue;
      const std::size_t pixel = static_cast<std::size_t>(y) * raster.width + static_cast<std::size_t>(x);
      if (raster.point[pixel] != Raster::kNoPoint && raster.depth[pixel] <= depth) continue;
      raster.point[pixel] = point.point;
      raster.depth[pixel] = depth;
    }
  }
}

}  // namespace

Raster rasterize_projected(const CloudView& cloud, std::uint32_t width, std::uint32_t height,
                           const std::optional<Eigen::Vector3f>& view_from) {
  Raster raster(width, height);
  const std::vector<std::uint32_t> points = finite_points(cloud);
  std::vector<ProjectedPoint> projected = project(cloud, points, choose_viewpoint(cloud, points, view_from));
  const Framing framing = frame(projected, width, height);
  const auto place_of = [&](const ProjectedPoint& point) {
    return Place{0.5 * width + framing.scale * (point.u - framing.u),
                 0.5 * height + framing.scale * (point.v - framing.v)};
  };
  std::erase_if(projected, [&](const ProjectedPoint& point) {
    const Place place = place_of(point);
    return !(std::abs(place.x) < 2.0 * width && std::abs(place.y) < 2.0 * height);
  });
  PointDensity density(width, height);
  for (const ProjectedPoint& point : projected) density.add(place_of(point));
  for (const ProjectedPoint& point : projected) {
    const Place place = place_of(point);
    splat(point, place, density.radius(place), raster);
  }
  close_holes(raster);
  return raster;
}

}  // namespace segserve::picture
