// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <limits>

#include "core/lab/picture/raster.hpp"

namespace segserve::picture {
namespace {

/// Depths that differ by less than this share belong to one surface, and by more than the other to two.
constexpr float kSameSurface = 0.03F;
constexpr float kBehind = 0.05F;

/// Four directions; the opposite ones complete them.
constexpr std::array<std::array<int, 2>, 4> kDirections{{{1, 0}, {0, 1}, {1, 1}, {1, -1}}};

class HoleCloser {
 public:
  explicit HoleCloser(const Raster& raster) : raster_(raster) {}

  /// The pixel of the surface around a hole, if this pixel is part of one whose edge is `reach` pixels away; else the
  /// pixel itself.
  std::size_t source_of(std::size_t x, std::size_t y, int reach) const {
    const std::size_t pixel = y * raster_.width + x;
    const float depth = depth_at(pixel);
    std::size_t best = pixel;
    int closed = 0;
    for (const auto& [dx, dy] : kDirections) {
      const std::size_t a = neighbor(x, y, reach * dx, reach * dy);
      const std::size_t b = neighbor(x, y, -reach * dx, -reach * dy);
      if (a == kNone || b == kNone || !covers(a, b, depth)) continue;
      ++closed;
      const std::size_t nearer = raster_.depth[a] <= raster_.depth[b] ? a : b;
      if (best == pixel || raster_.depth[nearer] < raster_.depth[best]) best = nearer;
    }
    return closed >= 3 ? best : pixel;
  }

 private:
  static constexpr std::size_t kNone = std::numeric_limits<std::size_t>::max();

  float depth_at(std::size_t pixel) const {
    return raster_.point[pixel] == Raster::kNoPoint ? std::numeric_limits<float>::infinity() : raster_.depth[pixel];
  }

  std::size_t neighbor(std::size_t x, std::size_t y, int dx, int dy) const {
    const std::ptrdiff_t nx = static_cast<std::ptrdiff_t>(x) + dx;
    const std::ptrdiff_t ny = static_cast<std::ptrdiff_t>(y) + dy;
    const bool is_inside = nx >= 0 && ny >= 0 && nx < static_cast<std::ptrdiff_t>(raster_.width) &&
                           ny < static_cast<std::ptrdiff_t>(raster_.height);
    return is_inside ? static_cast<std::size_t>(ny) * raster_.width + static_cast<std::size_t>(nx) : kNone;
  }

  /// Whether two pixels show one surface that lies before this depth.
  bool covers(std::size_t a, std::size_t b, float depth) const {
    const float da = depth_at(a);
    const float db = depth_at(b);
    if (!std::isfinite(da) || !std::isfinite(db)) return false;
    return std::abs(da - db) <= kSameSurface * std::max(da, db) && std::max(da, db) * (1.0F + kBehind) < depth;
  }

  const Raster& raster_;
};

void close_once(int reach, Raster& raster) {
  const Raster before = raster;
  const HoleCloser closer(before);
  for (std::size_t y = 0; y < raster.height; ++y) {
    for (std::size_t x = 0; x < raster.width; ++x) {
      const std::size_t pixel = y * raster.width + x;
      const std::size_t source = closer.source_of(x, y, reach);
      raster.point[pixel] = before.point[source];
      raster.depth[pixel] = before.depth[source];
    }
  }
}

}  // namespace

void close_holes(Raster& raster) {
  for (const int reach : {1, 2, 3, 1}) close_once(reach, raster);
}

}  // namespace segserve::picture
