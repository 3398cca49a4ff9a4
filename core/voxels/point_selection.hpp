// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>

#include "core/voxels/simd/voxel_kernels.hpp"
#include "segserve/cloud.hpp"
#include "segserve/options.hpp"

namespace segserve {

/// Selects the points that are segmented at all: those in the crop box and in range of the sensor, both closed. The
/// kernel find_cells compares in single precision, which is faster. The box is exact all the same, because its limits
/// are rounded inwards; distances have the error of a float.
class PointSelection {
 public:
  /// Selects every point.
  PointSelection() = default;

  /// Selects as the options say, which must be valid in this view.
  PointSelection(const Options& options, const View& view)
      : limits_{.low = {not_below(options.crop_min_x), not_below(options.crop_min_y), not_below(options.crop_min_z)},
                .high = {not_above(options.crop_max_x), not_above(options.crop_max_y), not_above(options.crop_max_z)},
                .sensor = {},
                .nearest_squared = squared(options.range_min.value_or(0)),
                .farthest_squared = squared(options.range_max.value_or(kInfinity))} {
    if (view.sensor) std::copy_n(view.sensor->data(), 3, limits_.sensor);
    for (const auto& limit : {options.crop_min_x, options.crop_min_y, options.crop_min_z, options.crop_max_x,
                              options.crop_max_y, options.crop_max_z, options.range_min, options.range_max}) {
      all_ = all_ && !limit;
    }
  }

  bool all() const { return all_; }

  /// Whether a finite point is selected.
  bool selects(float x, float y, float z) const {
    if (all_) return true;
    const SelectionLimits& l = limits_;
    const float dx = x - l.sensor[0], dy = y - l.sensor[1], dz = z - l.sensor[2];
    const float distance_squared = dx * dx + dy * dy + dz * dz;
    return x >= l.low[0] && x <= l.high[0] && y >= l.low[1] && y <= l.high[1] && z >= l.low[2] && z <= l.high[2] &&
           distance_squared >= l.nearest_squared && distance_squared <= l.farthest_squared;
  }

  const SelectionLimits& limits() const { return limits_; }

 private:
  static constexpr float kInfinity = std::numeric_limits<float>::infinity();

  static float squared(double limit) { return static_cast<float>(limit * limit); }
  /// The smallest float that is not below the limit; -infinity without a limit.
  static float not_below(std::optional<double> limit) {
    const auto rounded = static_cast<float>(limit.value_or(-kInfinity));
    return limit && rounded < *limit ? std::nextafter(rounded, kInfinity) : rounded;
  }
  /// The greatest float that is not above the limit; infinity without a limit.
  static float not_above(std::optional<double> limit) {
    const auto rounded = static_cast<float>(limit.value_or(kInfinity));
    return limit && rounded > *limit ? std::nextafter(rounded, -kInfinity) : rounded;
  }

  bool all_ = true;
  SelectionLimits limits_{};
};

}  // namespace segserve
