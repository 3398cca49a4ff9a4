#pragma once

#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <optional>

#include "segserve/cloud/cloud.hpp"
#include "segserve/options/options.hpp"

namespace segserve {

/// Which points are segmented at all: those in the crop box and in range of the sensor, both closed. Loops over
/// points compare in single precision, twice as fast as in double: the box is exact all the same, as its limits are
/// rounded inwards; distances have the error of a float.
class Selection {
 public:
  /// Selects every point.
  Selection() = default;

  /// As the options say; they must be valid in this view.
  Selection(const Options& options, const View& view)
      : low_{not_below(options.crop_min_x), not_below(options.crop_min_y), not_below(options.crop_min_z)},
        high_{not_above(options.crop_max_x), not_above(options.crop_max_y), not_above(options.crop_max_z)},
        sensor_(view.sensor.value_or(std::array<float, 3>{})),
        nearest_squared_(squared(options.range_min.value_or(0))),
        farthest_squared_(squared(options.range_max.value_or(kInfinity))) {
    for (const auto& limit : {options.crop_min_x, options.crop_min_y, options.crop_min_z, options.crop_max_x,
                              options.crop_max_y, options.crop_max_z, options.range_min, options.range_max}) {
      all_ = all_ && !limit;
    }
  }

  bool all() const { return all_; }

  /// All bits set if the point is selected, else 0; branch-free, so that loops over points vectorise. Any value for
  /// a point that is not finite.
  std::int32_t mask(float x, float y, float z) const {
    const float dx = x - sensor_[0], dy = y - sensor_[1], dz = z - sensor_[2];
    const float distance_squared = dx * dx + dy * dy + dz * dz;
    const auto between = [](float low, float value, float high) {
      return static_cast<std::int32_t>(value >= low) & static_cast<std::int32_t>(value <= high);
    };
    return -(between(low_[0], x, high_[0]) & between(low_[1], y, high_[1]) & between(low_[2], z, high_[2]) &
             between(nearest_squared_, distance_squared, farthest_squared_));
  }

 private:
  static constexpr float kInfinity = std::numeric_limits<float>::infinity();

  static float squared(double limit) { return static_cast<float>(limit * limit); }
  /// The smallest float that is not below the limit, and the greatest that is not above.
  static float not_below(std::optional<double> limit) {
    const auto rounded = static_cast<float>(limit.value_or(-kInfinity));
    return limit && rounded < *limit ? std::nextafter(rounded, kInfinity) : rounded;
  }
  static float not_above(std::optional<double> limit) {
    const auto rounded = static_cast<float>(limit.value_or(kInfinity));
    return limit && rounded > *limit ? std::nextafter(rounded, -kInfinity) : rounded;
  }

  bool all_ = true;
  std::array<float, 3> low_{-kInfinity, -kInfinity, -kInfinity}, high_{kInfinity, kInfinity, kInfinity};
  std::array<float, 3> sensor_{};
  float nearest_squared_ = 0, farthest_squared_ = kInfinity;
};

}  // namespace segserve
