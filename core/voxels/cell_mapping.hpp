#pragma once

#include <bit>
#include <cstddef>
#include <cstdint>

#include "core/voxels/voxel_key.hpp"

namespace segserve {

/// How points become cells and fixed-point coordinates (the kernel find_cells does it). The fixed-point unit is the
/// power of two below voxel / 4096 (2 micrometres at 8 mm), the range 2^30 units on either side.
struct CellMapping {
  explicit CellMapping(double resolution)
      : cells_per_metre(static_cast<float>(1 / resolution)), units_per_metre(unit_scale(resolution)) {}

  double unit() const { return 1 / static_cast<double>(units_per_metre); }
  /// Coordinates must be below this in magnitude, metres.
  float coordinate_limit() const { return kUnitLimit / units_per_metre; }

  static constexpr float kUnitLimit = 1073741824.0F;                      // 2^30
  static constexpr float kCellLimit = static_cast<float>(kCellBias - 2);  // neighbours never leave the 21 bits
  static constexpr float kSmallestDepth = 1.1754944e-38F;  // below it, numbers are subnormal and ln is not defined

  const float cells_per_metre;
  const float units_per_metre;

 private:
  static float unit_scale(double resolution) {
    const int exponent = static_cast<int>(std::bit_cast<std::uint64_t>(resolution) >> 52U) - 1023;  // floor(log2)
    return std::bit_cast<float>(static_cast<std::uint32_t>(12 - exponent + 127) << 23U);
  }
};

}  // namespace segserve
