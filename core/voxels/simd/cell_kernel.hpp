// Part of the kernels; see core/simd/simd_vectors.hpp. The cells of points, without branches: 0.8 ms a frame.
#pragma once

#include "core/simd/simd_vectors.hpp"
#include "core/voxels/cell_mapping.hpp"
#include "core/voxels/simd/voxel_kernels.hpp"

namespace segserve::SEGSERVE_KERNELS {
namespace {

SEGSERVE_INLINE Int finite(Float v) {
  constexpr std::int32_t kExponent = 0x7f800000;  // all ones: infinity or not a number
  return (reinterpret_cast<Int>(v) & kExponent) != kExponent;
}

SEGSERVE_INLINE Int larger(Int a, Int b) { return a > b ? a : b; }

/// Whether all three are below the limit in magnitude: without their signs, floats compare as their bits do.
SEGSERVE_INLINE Int in_range(Float x, Float y, Float z, float limit) {
  constexpr std::int32_t kMagnitude = 0x7fffffff;
  const auto magnitude = [](Float v) SEGSERVE_INLINE_LAMBDA { return reinterpret_cast<Int>(v) & kMagnitude; };
  return larger(larger(magnitude(x), magnitude(y)), magnitude(z)) < reinterpret_cast<Int>(Float{} + limit);
}

SEGSERVE_INLINE Int floor_to_int(Float v) {
#if defined(__AVX2__)
  return __builtin_convertvector(__builtin_ia32_roundps256(v, 1), Int);
#else
  const Int truncated = __builtin_convertvector(v, Int);
  return truncated + (v < __builtin_convertvector(truncated, Float));  // "true" is -1
#endif
}

/// math::ln of single precision.
SEGSERVE_INLINE Float logarithm(Float x) {
  constexpr std::int32_t kSqrtHalf = 0x3f3504f3;
  const Int shifted = reinterpret_cast<Int>(x) - kSqrtHalf;
  const Float exponent = __builtin_convertvector(shifted >> 23, Float);
  const Float m = reinterpret_cast<Float>((shifted & 0x007fffff) + kSqrtHalf);
  const Float s = (m - 1.0F) / (m + 1.0F);
  const Float q = s * s;
  const Float series = 2.0F + q * (2.0F / 3 + q * (2.0F / 5 + q * (2.0F / 7 + q * (2.0F / 9))));
  return exponent * 0.693147181F + s * series;
}

/// As Selection says.
SEGSERVE_INLINE Int selected(const SelectionLimits& s, Float x, Float y, Float z) {
  const Float dx = x - s.sensor[0], dy = y - s.sensor[1], dz = z - s.sensor[2];
  const Float distance_squared = dx * dx + dy * dy + dz * dz;
  const auto between = [](float low, Float value, float high)
                           SEGSERVE_INLINE_LAMBDA { return (value >= low) & (value <= high); };
  return between(s.low[0], x, s.high[0]) & between(s.low[1], y, s.high[1]) & between(s.low[2], z, s.high[2]) &
         between(s.nearest_squared, distance_squared, s.farthest_squared);
}

/// Low and high halves of keys become keys.
SEGSERVE_INLINE void store_keys(Int low, Int high, std::uint64_t* keys) {
#if defined(__AVX2__)
  store(__builtin_shufflevector(low, high, 0, 8, 1, 9, 2, 10, 3, 11), keys);
  store(__builtin_shufflevector(low, high, 4, 12, 5, 13, 6, 14, 7, 15), keys + kFloats / 2);
#else
  store(__builtin_shufflevector(low, high, 0, 4, 1, 5), keys);
  store(__builtin_shufflevector(low, high, 2, 6, 3, 7), keys + kFloats / 2);
#endif
}

/// Of kFloats points that are not finite. They come in patches: 0.2 ms of a Kinect frame, of which they are a third.
SEGSERVE_INLINE Int no_cell(std::size_t i, const CellOutput& out) {
  store_keys(~Int{}, ~Int{}, out.keys + i);
  store(Int{}, out.x + i);
  store(Int{}, out.y + i);
  store(Int{}, out.z + i);
  return Int{};
}

/// kFloats points from the first on. Returns the lanes that are finite but not valid.
template <bool camera>
SEGSERVE_INLINE Int find_cell(const CellInput in, Float x, Float y, Float z, std::size_t i, const CellOutput out) {
  Int is_finite = finite(x) & finite(y) & finite(z);
  if (!any(is_finite)) return no_cell(i, out);
  if (in.selection != nullptr) is_finite &= selected(*in.selection, x, y, z);
  const Float fixed[3] = {x * in.units_per_metre, y * in.units_per_metre, z * in.units_per_metre};
  Int valid = in_range(fixed[0], fixed[1], fixed[2], CellMapping::kUnitLimit);
  if constexpr (camera) {
    const Int deep = z >= CellMapping::kSmallestDepth;
    valid &= deep;
    const Float depth = deep ? z : 1.0F - Float{};
    x /= depth, y /= depth, z = logarithm(depth);
  }
  x *= in.cells_per_metre, y *= in.cells_per_metre, z *= in.cells_per_metre;
  valid &= in_range(x, y, z, CellMapping::kCellLimit);
  const Int taken = is_finite & valid;
  const auto biased = [taken](Float v) SEGSERVE_INLINE_LAMBDA { return floor_to_int(taken ? v : Float{}) + kCellBias; };
  const Int cx = biased(x), cy = biased(y), cz = biased(z);
  store_keys(cx | cy << kCellBits | ~is_finite, cy >> (32 - kCellBits) | cz << (2 * kCellBits - 32) | ~is_finite,
             out.keys + i);
  const auto rounded = [taken](Float v) SEGSERVE_INLINE_LAMBDA { return floor_to_int(taken ? v + 0.5F : Float{}); };
  store(rounded(fixed[0]), out.x + i);
  store(rounded(fixed[1]), out.y + i);
  store(rounded(fixed[2]), out.z + i);
  return is_finite & ~valid;
}

template <bool camera>
SEGSERVE_INLINE std::size_t find_all_cells(const CellInput in, std::size_t count, const CellOutput out) {
  std::size_t i = 0;
  const auto first_of = [&](Int faults) SEGSERVE_INLINE_LAMBDA {
    for (std::size_t k = 0; k < kFloats; ++k) {
      if (faults[k] != 0) return i + k;
    }
    return count;
  };
  for (; i + kFloats <= count; i += kFloats) {
    const Int faults =
        find_cell<camera>(in, load<Float>(in.x + i), load<Float>(in.y + i), load<Float>(in.z + i), i, out);
    if (any(faults)) return first_of(faults);
  }
  if (i == count) return count;
  Float rest[3];
  const float* const planes[3] = {in.x, in.y, in.z};
  for (int axis = 0; axis < 3; ++axis) {
    for (std::size_t k = 0; k < kFloats; ++k) {
      rest[axis][k] = i + k < count ? planes[axis][i + k] : __builtin_nanf("");
    }
  }
  const Int faults = find_cell<camera>(in, rest[0], rest[1], rest[2], i, out);
  return any(faults) ? first_of(faults) : count;
}

std::size_t find_cells(const CellInput& in, std::size_t count, const CellOutput& out) {
  return in.camera ? find_all_cells<true>(in, count, out) : find_all_cells<false>(in, count, out);
}

}  // namespace
}  // namespace segserve::SEGSERVE_KERNELS
