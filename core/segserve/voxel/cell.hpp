#pragma once

#include <bit>
#include <cstddef>
#include <cstdint>

#include "segserve/cloud/cloud.hpp"
#include "segserve/math/elementary.hpp"
#include "segserve/voxel/voxel_grid.hpp"

namespace segserve {

/// Maps points to cells and to fixed-point coordinates. The fixed-point unit is the power of two
/// below voxel / 4096 (2 micrometres at 8 mm), the range 2^30 units on either side.
class CellMapping {
 public:
  explicit CellMapping(double resolution)
      : cells_per_metre_(static_cast<float>(1 / resolution)), units_per_metre_(unit_scale(resolution)) {}

  double unit() const { return 1 / static_cast<double>(units_per_metre_); }
  /// Coordinates must be below this in magnitude, metres.
  float coordinate_limit() const { return kUnitLimit / units_per_metre_; }

  std::int32_t fixed_point(float metres) const { return math::floor_to_int(metres * units_per_metre_ + 0.5F); }

  /// The cell of one point, and what it is: all bits set for "yes", so that loops over points
  /// vectorise. The coordinates are those of the origin's cell unless the point is finite and valid.
  struct Cell {
    std::int32_t x, y, z;
    std::int32_t finite, valid;
  };

  template <ViewKind kind>
  Cell cell(float x, float y, float z) const {
    const std::int32_t finite = mask(is_finite(x, y, z));
    std::int32_t valid = in_range(x * units_per_metre_, kUnitLimit) & in_range(y * units_per_metre_, kUnitLimit) &
                         in_range(z * units_per_metre_, kUnitLimit);
    if constexpr (kind == ViewKind::kCamera) {
      valid &= mask(z >= kSmallest);
      const float depth = z >= kSmallest ? z : 1.0F;
      x /= depth, y /= depth, z = math::ln(depth);
    }
    x *= cells_per_metre_, y *= cells_per_metre_, z *= cells_per_metre_;
    valid &= in_range(x, kCellLimit) & in_range(y, kCellLimit) & in_range(z, kCellLimit);
    const auto coordinate = [valid](float v) { return math::floor_to_int(valid != 0 ? v : 0.0F); };
    return {coordinate(x), coordinate(y), coordinate(z), finite, valid};
  }

  static VoxelKey key(std::int32_t x, std::int32_t y, std::int32_t z) {
    const auto biased = [](std::int32_t c) { return static_cast<VoxelKey>(static_cast<std::uint32_t>(c + kCellBias)); };
    return biased(z) << (2 * kCellBits) | biased(y) << kCellBits | biased(x);
  }

 private:
  static constexpr float kUnitLimit = 1073741824.0F;                      // 2^30
  static constexpr float kCellLimit = static_cast<float>(kCellBias - 2);  // neighbours never leave the 21 bits
  static constexpr float kSmallest = 1.1754944e-38F;  // below it, numbers are subnormal and ln is not defined

  static float unit_scale(double resolution) {
    const int exponent = static_cast<int>(std::bit_cast<std::uint64_t>(resolution) >> 52U) - 1023;  // floor(log2)
    return std::bit_cast<float>(static_cast<std::uint32_t>(12 - exponent + 127) << 23U);
  }

  static std::int32_t mask(bool condition) { return -static_cast<std::int32_t>(condition); }
  static std::int32_t in_range(float v, float limit) { return mask(v > -limit) & mask(v < limit); }

  float cells_per_metre_;
  float units_per_metre_;
};

}  // namespace segserve
