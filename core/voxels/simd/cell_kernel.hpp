// SPDX-License-Identifier: Apache-2.0
// A kernel; see core/simd/simd_vectors.hpp. Finds the cells of points without branches.
#pragma once

#include "core/simd/simd_vectors.hpp"
#include "core/voxels/cell_mapping.hpp"
#include "core/voxels/simd/voxel_kernels.hpp"

namespace segserve::SEGSERVE_SIMD_TARGET {
namespace {

SEGSERVE_INLINE Ints finite(Floats v) {
  constexpr std::int32_t kExponent = 0x7f800000;  // All ones stand for infinity or not a number.
  return (reinterpret_cast<Ints>(v) & kExponent) != kExponent;
}

SEGSERVE_INLINE Ints larger(Ints a, Ints b) { return a > b ? a : b; }

/// Whether all three are below the limit in magnitude. Without their signs, floats compare as their bits do.
SEGSERVE_INLINE Ints in_range(Floats x, Floats y, Floats z, float limit) {
  constexpr std::int32_t kMagnitude = 0x7fffffff;
  const auto magnitude = [](Floats v) SEGSERVE_INLINE_LAMBDA { return reinterpret_cast<Ints>(v) & kMagnitude; };
  return larger(larger(magnitude(x), magnitude(y)), magnitude(z)) < reinterpret_cast<Ints>(Floats{} + limit);
}

SEGSERVE_INLINE Ints floor_to_int(Floats v) {
#if defined(__AVX2__)
  return __builtin_convertvector(__builtin_ia32_roundps256(v, 1), Ints);
#else
  const Ints truncated = __builtin_convertvector(v, Ints);
  return truncated + (v < __builtin_convertvector(truncated, Floats));  // "true" is -1
#endif
}

/// The natural logarithm in single precision; see `ln` in core/simd/elementary_functions.hpp.
SEGSERVE_INLINE Floats logarithm(Floats x) {
  constexpr std::int32_t kSqrtHalf = 0x3f3504f3;
  const Ints shifted = reinterpret_cast<Ints>(x) - kSqrtHalf;
  const Floats exponent = __builtin_convertvector(shifted >> 23, Floats);
  const Floats m = reinterpret_cast<Floats>((shifted & 0x007fffff) + kSqrtHalf);
  const Floats s = (m - 1.0F) / (m + 1.0F);
  const Floats q = s * s;
  const Floats series = 2.0F + q * (2.0F / 3 + q * (2.0F / 5 + q * (2.0F / 7 + q * (2.0F / 9))));
  return exponent * 0.693147181F + s * series;
}

/// Whether the points are within the limits.
SEGSERVE_INLINE Ints selected(const SelectionLimits& s, Floats x, Floats y, Floats z) {
  const Floats dx = x - s.sensor[0], dy = y - s.sensor[1], dz = z - s.sensor[2];
  const Floats distance_squared = dx * dx + dy * dy + dz * dz;
  const auto between = [](float low, Floats value, float high)
                           SEGSERVE_INLINE_LAMBDA { return (value >= low) & (value <= high); };
  return between(s.low[0], x, s.high[0]) & between(s.low[1], y, s.high[1]) & between(s.low[2], z, s.high[2]) &
         between(s.nearest_squared, distance_squared, s.farthest_squared);
}

/// Stores keys, given their low and high halves.
SEGSERVE_INLINE void store_keys(Ints low, Ints high, std::uint64_t* keys) {
#if defined(__AVX2__)
  store(__builtin_shufflevector(low, high, 0, 8, 1, 9, 2, 10, 3, 11), keys);
  store(__builtin_shufflevector(low, high, 4, 12, 5, 13, 6, 14, 7, 15), keys + kFloatLanes / 2);
#else
  store(__builtin_shufflevector(low, high, 0, 4, 1, 5), keys);
  store(__builtin_shufflevector(low, high, 2, 6, 3, 7), keys + kFloatLanes / 2);
#endif
}

/// Writes the output for kFloatLanes points that are not finite. Depth images have whole patches of them.
SEGSERVE_INLINE Ints no_cell(std::size_t i, const CellOutput& out) {
  store_keys(~Ints{}, ~Ints{}, out.keys + i);
  store(Ints{}, out.x + i);
  store(Ints{}, out.y + i);
  store(Ints{}, out.z + i);
  return Ints{};
}

/// Finds the cells of kFloatLanes points, of which i is the first. Returns the lanes that are selected and finite but
/// have no cell.
template <bool camera>
SEGSERVE_INLINE Ints find_cell(const CellInput in, Floats x, Floats y, Floats z, std::size_t i, const CellOutput out) {
  Ints is_finite = finite(x) & finite(y) & finite(z);
  if (!any(is_finite)) return no_cell(i, out);
  if (in.selection != nullptr) is_finite &= selected(*in.selection, x, y, z);
  const Floats fixed[3] = {x * in.units_per_meter, y * in.units_per_meter, z * in.units_per_meter};
  Ints valid = in_range(fixed[0], fixed[1], fixed[2], CellMapping::kUnitLimit);
  if constexpr (camera) {
    const Ints deep = z >= CellMapping::kSmallestDepth;
    valid &= deep;
    const Floats depth = deep ? z : 1.0F - Floats{};
    x /= depth, y /= depth;
    const Floats elongated = in.elongation_depth_logarithm + (1.0F - in.elongation_depth / depth);
    z = depth > in.elongation_depth ? elongated : logarithm(depth);
  }
  x *= in.cells_per_meter, y *= in.cells_per_meter, z *= in.cells_per_meter;
  valid &= in_range(x, y, z, CellMapping::kCellLimit);
  const Ints taken = is_finite & valid;
  const auto biased = [taken](Floats v)
                          SEGSERVE_INLINE_LAMBDA { return floor_to_int(taken ? v : Floats{}) + kCellBias; };
  const Ints cx = biased(x), cy = biased(y), cz = biased(z);
  store_keys(cx | cy << kCellBits | ~taken, cy >> (32 - kCellBits) | cz << (2 * kCellBits - 32) | ~taken, out.keys + i);
  const auto rounded = [taken](Floats v) SEGSERVE_INLINE_LAMBDA { return floor_to_int(taken ? v + 0.5F : Floats{}); };
  store(rounded(fixed[0]), out.x + i);
  store(rounded(fixed[1]), out.y + i);
  store(rounded(fixed[2]), out.z + i);
  return is_finite & ~valid;
}

/// Counts the lanes without a cell, of which i is the index of the first lane.
template <bool camera>
void count_faults(Ints faults, Floats x, Floats y, Floats z, std::size_t i, PointsWithoutCell& without) {
  for (std::size_t k = 0; k < kFloatLanes; ++k) {
    if (faults[k] == 0) continue;
    if (camera && x[k] == 0 && y[k] == 0 && z[k] == 0) {
      ++without.zeros;
    } else {
      if (without.others == 0) without.first_other = i + k;
      ++without.others;
    }
  }
}

template <bool camera>
SEGSERVE_INLINE PointsWithoutCell find_all_cells(const CellInput in, std::size_t count, const CellOutput out) {
  PointsWithoutCell without;
  std::size_t i = 0;
  for (; i + kFloatLanes <= count; i += kFloatLanes) {
    const Floats x = load<Floats>(in.x + i), y = load<Floats>(in.y + i), z = load<Floats>(in.z + i);
    const Ints faults = find_cell<camera>(in, x, y, z, i, out);
    if (any(faults)) count_faults<camera>(faults, x, y, z, i, without);
  }
  if (i == count) return without;
  Floats rest[3];
  const float* const planes[3] = {in.x, in.y, in.z};
  for (int axis = 0; axis < 3; ++axis) {
    for (std::size_t k = 0; k < kFloatLanes; ++k) {
      rest[axis][k] = i + k < count ? planes[axis][i + k] : __builtin_nanf("");
    }
  }
  const Ints faults = find_cell<camera>(in, rest[0], rest[1], rest[2], i, out);
  if (any(faults)) count_faults<camera>(faults, rest[0], rest[1], rest[2], i, without);
  return without;
}

PointsWithoutCell find_cells(const CellInput& in, std::size_t count, const CellOutput& out) {
  return in.camera ? find_all_cells<true>(in, count, out) : find_all_cells<false>(in, count, out);
}

}  // namespace
}  // namespace segserve::SEGSERVE_SIMD_TARGET
