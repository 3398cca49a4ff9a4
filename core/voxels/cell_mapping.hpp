// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <bit>
#include <cstddef>
#include <cstdint>

#include "core/base/voxel_scale.hpp"
#include "core/math/elementary.hpp"
#include "core/voxels/voxel_key.hpp"

namespace segserve {

/// The constants by which the kernel find_cells turns points into cells and fixed-point coordinates. The unit of the
/// fixed-point coordinates is the greatest power of two that is not above voxel / 4096 (2 micrometers at 8 mm, 61 in a
/// sweep); their range is 2^30 units on either side of 0.
struct CellMapping {
  explicit CellMapping(const VoxelScale& voxel_scale)
      : scale(voxel_scale),
        cells_per_meter(static_cast<float>(1 / scale.voxel)),
        units_per_meter(unit_scale(scale.sweep ? kVoxelOfSweep : scale.voxel)),
        elongation_depth(static_cast<float>(scale.elongation_depth)),
        elongation_depth_logarithm(scale.elongation_depth < kFar ? static_cast<float>(math::ln(scale.elongation_depth))
                                                                 : 0) {}

  double unit() const { return 1 / static_cast<double>(units_per_meter); }
  /// Coordinates must be below this in magnitude, meters.
  float coordinate_limit() const { return kUnitLimit / units_per_meter; }

  static constexpr float kUnitLimit = 1073741824.0F;                      // 2^30
  static constexpr float kCellLimit = static_cast<float>(kCellBias - 2);  // Neighbors never leave the 21 bits.
  static constexpr float kSmallestDepth = 1.1754944e-38F;  // Below it, numbers are subnormal and ln is not defined.

  const VoxelScale scale;
  const float cells_per_meter;
  const float units_per_meter;
  const float elongation_depth;            ///< VoxelScale::elongation_depth, meters
  const float elongation_depth_logarithm;  ///< its natural logarithm; 0 if it is beyond all points

 private:
  static constexpr double kFar = 1e30;           // meters
  static constexpr double kVoxelOfSweep = 0.25;  // meters, at the usual ranges

  static float unit_scale(double resolution) {
    const int exponent = static_cast<int>(std::bit_cast<std::uint64_t>(resolution) >> 52U) - 1023;  // floor(log2)
    return std::bit_cast<float>(static_cast<std::uint32_t>(12 - exponent + 127) << 23U);
  }
};

}  // namespace segserve
