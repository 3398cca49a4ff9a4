// SPDX-License-Identifier: Apache-2.0
#include "segserve/codec/point_spacing.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <vector>

#include "core/codec/common/spacing_search.hpp"

namespace segserve::codec {
namespace {

constexpr std::size_t kSample = 512, kMostVisits = 20'000;

/// The finite points, sorted by their position along the axis in which they extend most.
class SortedPoints {
 public:
  SortedPoints(const CloudView& cloud, StopCheck& check) : planes_{cloud.x, cloud.y, cloud.z} {
    constexpr float kInfinity = std::numeric_limits<float>::infinity();
    std::array<float, 3> low{kInfinity, kInfinity, kInfinity}, high{-kInfinity, -kInfinity, -kInfinity};
    check.for_each(0, cloud.size(), [&](std::size_t i) {
      if (!is_finite(cloud.x[i], cloud.y[i], cloud.z[i])) return;
      order_.push_back(static_cast<std::uint32_t>(i));
      for (std::size_t axis = 0; axis < 3; ++axis) {
        low[axis] = std::min(low[axis], planes_[axis][i]);
        high[axis] = std::max(high[axis], planes_[axis][i]);
      }
    });
    for (std::size_t axis = 1; axis < 3; ++axis) {
      if (high[axis] - low[axis] > high[axis_] - low[axis_]) axis_ = axis;
    }
    if (check.after(16 * order_.size())) return;
    std::ranges::sort(order_, {}, [plane = planes_[axis_]](std::uint32_t i) { return plane[i]; });
  }

  std::size_t size() const { return order_.size(); }

  /// The squared distance of the point at this place in the order from its nearest neighbor; infinite if there is none.
  double nearest(std::size_t place, StopCheck& check) const {
    double best = std::numeric_limits<double>::infinity();
    std::size_t visits = 0;
    bool low_open = true, high_open = true;
    for (std::size_t step = 1; (low_open || high_open) && visits < kMostVisits; ++step) {
      low_open = low_open && step <= place && visit(place, place - step, visits, best);
      high_open = high_open && place + step < order_.size() && visit(place, place + step, visits, best);
    }
    check.after(visits);
    return best;
  }

 private:
  /// Returns false if all points further on are farther away than the best.
  bool visit(std::size_t place, std::size_t other, std::size_t& visits, double& best) const {
    ++visits;
    const std::size_t i = order_[place], k = order_[other];
    const double along = static_cast<double>(planes_[axis_][i]) - planes_[axis_][k];
    if (along * along >= best) return false;
    double squared = 0;
    for (const auto& plane : planes_) squared += std::pow(static_cast<double>(plane[i]) - plane[k], 2);
    if (squared > 0) best = std::min(best, squared);
    return true;
  }

  std::array<std::span<const float>, 3> planes_;
  std::vector<std::uint32_t> order_;
  std::size_t axis_ = 0;
};

}  // namespace

std::optional<double> point_spacing(const CloudView& cloud, const StopToken& stop) {
  StopCheck check(stop);
  return point_spacing(cloud, check);
}

std::optional<double> point_spacing(const CloudView& cloud, StopCheck& check) {
  const SortedPoints points(cloud, check);
  std::vector<double> distances;
  const std::size_t every = std::max<std::size_t>(1, points.size() / kSample);
  for (std::size_t place = every / 2; place < points.size() && !check.stopped(); place += every) {
    const double squared = points.nearest(place, check);
    if (std::isfinite(squared)) distances.push_back(std::sqrt(squared));
  }
  if (distances.empty()) return std::nullopt;
  const auto middle = distances.begin() + static_cast<std::ptrdiff_t>(distances.size() / 2);
  std::nth_element(distances.begin(), middle, distances.end());
  return *middle;
}

}  // namespace segserve::codec
