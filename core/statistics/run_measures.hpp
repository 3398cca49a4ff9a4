// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstddef>
#include <cstdint>

#include "absl/numeric/int128.h"
#include "segserve/cloud.hpp"
#include "segserve/segment_statistics.hpp"

// The measures that the three passes over the points take. A run is a range [begin, end) of at most kMaxRun points of
// one segment. The measures of a segment are the sums (add) of those of its runs, and are the same for any order of its
// points.
namespace segserve {

inline constexpr std::size_t kMaxRun = 2048;

/// The first pass: extent, sum of the colors, and whether all points are finite.
struct Bounds {
  std::uint32_t points = 0;
  std::array<float, 3> low, high;  ///< meters; infinite without points
  std::array<std::uint64_t, 3> color{};
  bool finite = true;

  Bounds();
  void add(const Bounds& other);
};

Bounds bounds_of_run(const CloudView& cloud, std::size_t begin, std::size_t end);

/// Rounds coordinates to whole steps of a grid that divides the largest extent of a segment by 2^26: the squares of
/// kMaxRun coordinates then add up to less than 2^64.
class Grid {
 public:
  Grid() = default;
  explicit Grid(const Bounds& bounds);

  /// Steps from the low side of the segment. The point must be in the bounds.
  std::uint64_t x(float meters) const { return steps(meters, low_.x()); }
  std::uint64_t y(float meters) const { return steps(meters, low_.y()); }
  std::uint64_t z(float meters) const { return steps(meters, low_.z()); }
  Eigen::Vector3d meters(const Eigen::Vector3d& steps) const { return low_ + meters_per_step_ * steps; }

 private:
  std::uint64_t steps(float meters, double low) const {
    const double steps = (double{meters} - low) * steps_per_meter_;
    constexpr double kHalf = 0.5;  // rounds to the nearest, as steps are not negative
    return static_cast<std::uint32_t>(static_cast<std::int32_t>(steps + kHalf));
  }

  Eigen::Vector3d low_ = Eigen::Vector3d::Zero();
  double steps_per_meter_ = 0, meters_per_step_ = 0;
};

/// The second pass: exact sums of a segment's grid coordinates and of their products.
struct Moments {
  std::uint64_t x = 0, y = 0, z = 0;
  absl::uint128 xx = 0, xy = 0, xz = 0, yy = 0, yz = 0, zz = 0;

  void add(const Moments& other);
};

Moments moments_of_run(const CloudView& cloud, const Grid& grid, std::size_t begin, std::size_t end);

/// The third pass: least and greatest coordinate of a segment's points along its axes, from its centroid.
struct Reach {
  std::array<double, 3> low, high;  ///< meters; infinite without points

  Reach();
  void add(const Reach& other);
};

/// Needs the segment's centroid and the axes of its box.
Reach reach_of_run(const CloudView& cloud, const SegmentStatistics& segment, std::size_t begin, std::size_t end);

}  // namespace segserve
