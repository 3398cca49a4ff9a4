// SPDX-License-Identifier: Apache-2.0
#include "core/statistics/run_measures.hpp"

#include <algorithm>
#include <limits>
#include <span>

namespace segserve {
namespace {

constexpr double kGridSteps = 1 << 26;

template <typename Real>
void make_empty(std::array<Real, 3>& low, std::array<Real, 3>& high) {
  low.fill(std::numeric_limits<Real>::infinity());
  high.fill(-std::numeric_limits<Real>::infinity());
}

/// Widens [low, high] to the values. The compiler vectorizes no reduction to one floating-point number, hence the
/// array.
template <typename Real>
void widen(std::span<const Real> values, Real& low, Real& high) {
  constexpr std::size_t kLanes = 4;
  std::array<Real, kLanes> least, most;
  least.fill(low), most.fill(high);
  std::size_t i = 0;
  for (; i + kLanes <= values.size(); i += kLanes) {
    for (std::size_t k = 0; k < kLanes; ++k) {
      const Real v = values[i + k];
      least[k] = v < least[k] ? v : least[k];
      most[k] = v > most[k] ? v : most[k];
    }
  }
  for (; i < values.size(); ++i) {
    least[0] = std::min(least[0], values[i]);
    most[0] = std::max(most[0], values[i]);
  }
  low = *std::ranges::min_element(least);
  high = *std::ranges::max_element(most);
}

}  // namespace

Bounds::Bounds() { make_empty(low, high); }

void Bounds::add(const Bounds& other) {
  points += other.points;
  for (std::size_t k = 0; k < 3; ++k) {
    low[k] = std::min(low[k], other.low[k]);
    high[k] = std::max(high[k], other.high[k]);
    color[k] += other.color[k];
  }
  finite = finite && other.finite;
}

Bounds bounds_of_run(const CloudView& cloud, std::size_t begin, std::size_t end) {
  Bounds b;
  const std::size_t count = end - begin;
  b.points = static_cast<std::uint32_t>(count);
  widen(cloud.x.subspan(begin, count), b.low[0], b.high[0]);
  widen(cloud.y.subspan(begin, count), b.low[1], b.high[1]);
  widen(cloud.z.subspan(begin, count), b.low[2], b.high[2]);
  std::int32_t finite = 1;
  for (std::size_t i = begin; i < end; ++i) {
    finite &= static_cast<std::int32_t>(is_finite(cloud.x[i], cloud.y[i], cloud.z[i]));
  }
  b.finite = finite != 0;
  if (cloud.has_color()) {
    std::uint32_t sum_red = 0, sum_green = 0, sum_blue = 0;
    for (std::size_t i = begin; i < end; ++i) {
      const std::uint32_t rgb = cloud.rgb[i];
      sum_red += red(rgb), sum_green += green(rgb), sum_blue += blue(rgb);
    }
    b.color = {sum_red, sum_green, sum_blue};
  }
  return b;
}

Grid::Grid(const Bounds& bounds) : low_(bounds.low[0], bounds.low[1], bounds.low[2]) {
  double extent = 0;
  for (std::size_t k = 0; k < 3; ++k) extent = std::max(extent, double{bounds.high[k]} - double{bounds.low[k]});
  if (extent > 0) steps_per_meter_ = kGridSteps / extent, meters_per_step_ = extent / kGridSteps;
}

void Moments::add(const Moments& other) {
  x += other.x, y += other.y, z += other.z;
  xx += other.xx, xy += other.xy, xz += other.xz, yy += other.yy, yz += other.yz, zz += other.zz;
}

Moments moments_of_run(const CloudView& cloud, const Grid& grid, std::size_t begin, std::size_t end) {
  std::uint64_t sx = 0, sy = 0, sz = 0, xx = 0, xy = 0, xz = 0, yy = 0, yz = 0, zz = 0;
  for (std::size_t i = begin; i < end; ++i) {
    const std::uint64_t x = grid.x(cloud.x[i]), y = grid.y(cloud.y[i]), z = grid.z(cloud.z[i]);
    sx += x, sy += y, sz += z;
    xx += x * x, xy += x * y, xz += x * z, yy += y * y, yz += y * z, zz += z * z;
  }
  return {sx, sy, sz, xx, xy, xz, yy, yz, zz};
}

Reach::Reach() { make_empty(low, high); }

void Reach::add(const Reach& other) {
  for (std::size_t k = 0; k < 3; ++k) {
    low[k] = std::min(low[k], other.low[k]);
    high[k] = std::max(high[k], other.high[k]);
  }
}

Reach reach_of_run(const CloudView& cloud, const SegmentStatistics& segment, std::size_t begin, std::size_t end) {
  Reach reach;
  const std::size_t count = end - begin;
  const Eigen::Vector3d centroid = segment.centroid;
  std::array<double, kMaxRun> along;
  for (std::size_t k = 0; k < 3; ++k) {
    // Written out, because the order of Eigen's sums depends on the vectors that the CPU has.
    const Eigen::Vector3d axis = segment.box.axes.col(static_cast<Eigen::Index>(k));
    for (std::size_t i = 0; i < count; ++i) {
      along[i] = axis.x() * (double{cloud.x[begin + i]} - centroid.x()) +
                 axis.y() * (double{cloud.y[begin + i]} - centroid.y()) +
                 axis.z() * (double{cloud.z[begin + i]} - centroid.z());
    }
    widen(std::span<const double>(along).first(count), reach.low[k], reach.high[k]);
  }
  return reach;
}

}  // namespace segserve
