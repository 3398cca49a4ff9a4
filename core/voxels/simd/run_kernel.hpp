// SPDX-License-Identifier: Apache-2.0
// A kernel; see core/simd/simd_vectors.hpp. Finds runs of points in the same cell, and the sums over them. Sums over
// runs are differences of running sums. So no loop is as long as a run, whose length the CPU could not predict. The x,
// y, z and color of a point are in four lanes.
#pragma once

#include "core/simd/simd_vectors.hpp"
#include "core/voxels/simd/voxel_kernels.hpp"

namespace segserve::SEGSERVE_SIMD_TARGET {
namespace {

/// Moves the channels of colors apart within their words, so that each has bits to add up in.
template <typename Word>
SEGSERVE_INLINE Word separate_channels(Word rgb) {
  constexpr int kBits = PointSums::kColorBits;
  return (rgb & 0xff) | (rgb & 0xff00) << (kBits - 8) | (rgb & 0xff0000) << (2 * kBits - 16);
}

SEGSERVE_INLINE void add_point(const RunInput& in, std::size_t i, PointSums& sum) {
  sum.x += in.x[i];
  sum.y += in.y[i];
  sum.z += in.z[i];
  if (in.rgb != nullptr) sum.color += separate_channels<std::uint64_t>(in.rgb[i]);
}

#if defined(__AVX2__)

using Int64s4 = std::int64_t __attribute__((vector_size(32)));
using Int4 = std::int32_t __attribute__((vector_size(16)));

// GCC 12 itself would widen the four numbers two by two.
SEGSERVE_INLINE Int64s4 signed_longer(Int4 v) {
#if defined(__clang__)
  return __builtin_convertvector(v, Int64s4);
#else
  return reinterpret_cast<Int64s4>(__builtin_ia32_pmovsxdq256(v));
#endif
}
SEGSERVE_INLINE Int64s4 unsigned_longer(Int4 v) {
#if defined(__clang__)
  using Word4 = std::uint32_t __attribute__((vector_size(16)));
  return __builtin_convertvector(reinterpret_cast<Word4>(v), Int64s4);
#else
  return reinterpret_cast<Int64s4>(__builtin_ia32_pmovzxdq256(v));
#endif
}

/// Loads four points, each with x, y, z and color side by side.
SEGSERVE_INLINE void load_points(const RunInput in, std::size_t i, Int64s4 (&points)[4]) {
  const Int64s4 x = signed_longer(load<Int4>(in.x + i)), y = signed_longer(load<Int4>(in.y + i));
  const Int64s4 z = signed_longer(load<Int4>(in.z + i));
  Int64s4 color{};
  if (in.rgb != nullptr) color = separate_channels(unsigned_longer(load<Int4>(in.rgb + i)));
  const Int64s4 xy02 = __builtin_shufflevector(x, y, 0, 4, 2, 6), xy13 = __builtin_shufflevector(x, y, 1, 5, 3, 7);
  const Int64s4 zc02 = __builtin_shufflevector(z, color, 0, 4, 2, 6),
                zc13 = __builtin_shufflevector(z, color, 1, 5, 3, 7);
  points[0] = __builtin_shufflevector(xy02, zc02, 0, 1, 4, 5);
  points[1] = __builtin_shufflevector(xy13, zc13, 0, 1, 4, 5);
  points[2] = __builtin_shufflevector(xy02, zc02, 2, 3, 6, 7);
  points[3] = __builtin_shufflevector(xy13, zc13, 2, 3, 6, 7);
}

/// Sums up all points but the last few, and returns how many. The end of a run is written after each of its points, of
/// which the last one stays.
SEGSERVE_INLINE std::size_t sum_up_fours(const RunInput in, std::size_t count, std::size_t& found,
                                         const RunOutput out) {
  std::size_t i = 0, runs = 0;
  Int64s4 sum{}, before = Int64s4{} + static_cast<std::int64_t>(~in.keys[0]);
  for (; i + 4 <= count; i += 4) {
    const Int64s4 keys = load<Int64s4>(in.keys + i);
    const Int64s4 previous = __builtin_shufflevector(before, keys, 3, 4, 5, 6);
    before = keys;
    const int starts = __builtin_ia32_movmskpd256(reinterpret_cast<Doubles>(keys != previous));
    Int64s4 points[4];
    load_points(in, i, points);
#pragma GCC unroll 4
    for (std::size_t k = 0; k < 4; ++k) {
      runs += static_cast<std::size_t>(starts >> k & 1);
      sum += points[k];
      store(sum, out.sums + runs);
      out.ends[runs] = static_cast<std::uint32_t>(i + k + 1);
    }
  }
  found = runs;
  return i;
}

#else

SEGSERVE_INLINE std::size_t sum_up_fours(const RunInput&, std::size_t, std::size_t&, const RunOutput&) { return 0; }

#endif

std::size_t find_runs(const RunInput& in, std::size_t count, const RunOutput& out) {
  out.sums[0] = {};
  out.ends[0] = 0;
  std::size_t runs = 0;
  std::size_t i = sum_up_fours(in, count, runs, out);
  PointSums sum = out.sums[runs];
  for (; i < count; ++i) {
    runs += static_cast<std::size_t>(i == 0 || in.keys[i] != in.keys[i - 1]);
    add_point(in, i, sum);
    out.sums[runs] = sum;
    out.ends[runs] = static_cast<std::uint32_t>(i + 1);
  }
  return runs;
}

}  // namespace
}  // namespace segserve::SEGSERVE_SIMD_TARGET
