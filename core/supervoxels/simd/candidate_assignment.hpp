// Part of the kernels; see core/simd/simd_vectors.hpp. Distances of candidates to the centre of a cluster, and what
// follows.
#pragma once

#include "core/simd/simd_vectors.hpp"
#include "core/supervoxels/simd/growth_kernels.hpp"

namespace segserve::SEGSERVE_KERNELS {
namespace {

using growth::Claim;
using growth::Feature;
using growth::Turn;
using growth::Voxel;

SEGSERVE_INLINE Float square_root(Float v) {
#if defined(__AVX2__)
  return __builtin_ia32_sqrtps256(v);
#elif defined(__SSE2__)
  return __builtin_ia32_sqrtps(v);  // GCC 12 makes a loop four instructions of one root each
#else
  for (std::size_t i = 0; i < kFloats; ++i) v[i] = __builtin_sqrtf(v[i]);
  return v;
#endif
}

/// Four consecutive floats of as many voxels as a vector has lanes, each in a vector of its own.
struct FourColumns {
  Float a, b, c, d;
};

/// `part`: 0, 4 or 8, the first of the four floats of a voxel.
SEGSERVE_INLINE FourColumns columns(const Voxel* voxels, const std::uint32_t* of, std::size_t part) {
  const auto row = [&](std::size_t i) SEGSERVE_INLINE_LAMBDA { return &voxels[of[i]].feature.px + part; };
#if defined(__AVX2__)
  const auto two_rows = [&](std::size_t i) SEGSERVE_INLINE_LAMBDA {
    return __builtin_shufflevector(load<HalfFloat>(row(i)), load<HalfFloat>(row(i + 4)), 0, 1, 2, 3, 4, 5, 6, 7);
  };
  const Float r0 = two_rows(0), r1 = two_rows(1), r2 = two_rows(2), r3 = two_rows(3);
  const Float low01 = __builtin_shufflevector(r0, r1, 0, 8, 1, 9, 4, 12, 5, 13);
  const Float high01 = __builtin_shufflevector(r0, r1, 2, 10, 3, 11, 6, 14, 7, 15);
  const Float low23 = __builtin_shufflevector(r2, r3, 0, 8, 1, 9, 4, 12, 5, 13);
  const Float high23 = __builtin_shufflevector(r2, r3, 2, 10, 3, 11, 6, 14, 7, 15);
  return {__builtin_shufflevector(low01, low23, 0, 1, 8, 9, 4, 5, 12, 13),
          __builtin_shufflevector(low01, low23, 2, 3, 10, 11, 6, 7, 14, 15),
          __builtin_shufflevector(high01, high23, 0, 1, 8, 9, 4, 5, 12, 13),
          __builtin_shufflevector(high01, high23, 2, 3, 10, 11, 6, 7, 14, 15)};
#else
  const Float r0 = load<Float>(row(0)), r1 = load<Float>(row(1)), r2 = load<Float>(row(2)), r3 = load<Float>(row(3));
  const Float low01 = __builtin_shufflevector(r0, r1, 0, 4, 1, 5);
  const Float high01 = __builtin_shufflevector(r0, r1, 2, 6, 3, 7);
  const Float low23 = __builtin_shufflevector(r2, r3, 0, 4, 1, 5);
  const Float high23 = __builtin_shufflevector(r2, r3, 2, 6, 3, 7);
  return {__builtin_shufflevector(low01, low23, 0, 1, 4, 5), __builtin_shufflevector(low01, low23, 2, 3, 6, 7),
          __builtin_shufflevector(high01, high23, 0, 1, 4, 5), __builtin_shufflevector(high01, high23, 2, 3, 6, 7)};
#endif
}

struct Measured {
  Float distance;  // to the centre
  Int nearer;      // than to the owner
};

/// The distance of VCCS, of as many voxels as a vector has lanes.
template <bool colored>
SEGSERVE_INLINE Measured measure(const Feature& centre, float normal_weight, const Voxel* voxels,
                                 const std::uint32_t* of) {
  // px py pz nx, ny nz cr cg, cb distance
  const FourColumns first = columns(voxels, of, 0), second = columns(voxels, of, 4), third = columns(voxels, of, 8);
  const Float x = centre.px - first.a, y = centre.py - first.b, z = centre.pz - first.c;
  Float distance = square_root(x * x + y * y + z * z);
  if constexpr (colored) {
    const Float r = centre.cr - second.c, g = centre.cg - second.d, b = centre.cb - third.a;
    distance = distance + square_root(r * r + g * g + b * b);
  }
  const Float cosine = centre.nx * first.d + centre.ny * second.a + centre.nz * second.b;
  const Float absolute = reinterpret_cast<Float>(reinterpret_cast<Int>(cosine) & 0x7fffffff);
  distance = distance + normal_weight * (1.0F - absolute);
  return {distance, distance < third.b};
}

/// Candidates on their way to one of two lists.
struct Split {
  Claim* claims;
  std::uint32_t* kept;
  std::size_t claimed = 0, left = 0;

  /// The first `count` lanes. No branches: they would be mispredicted for every fourth candidate.
  SEGSERVE_INLINE void add(const Turn& turn, const std::uint32_t* of, const Measured& m, std::size_t count) {
    alignas(kLaneBytes) float distance[kFloats];
    alignas(kLaneBytes) std::int32_t nearer[kFloats];
    store(m.distance, distance);
    store(m.nearer, nearer);
#pragma GCC unroll 8
    for (std::size_t i = 0; i < count; ++i) {
      const std::uint32_t u = of[i];
      turn.voxels[u].seen = turn.number;
      claims[claimed].voxel = u;
      claims[claimed].distance = distance[i];
      kept[left] = u;
      const auto is_claim = static_cast<std::size_t>(nearer[i] & 1);
      claimed += is_claim;
      left += 1 - is_claim;
    }
  }
};

template <bool colored>
SEGSERVE_INLINE std::size_t split(const Turn& turn, float normal_weight, const Feature& centre,
                                  const std::uint32_t* candidates, std::size_t count, Split lists) {
  std::size_t i = 0;
  for (; i + kFloats <= count; i += kFloats) {
    std::uint32_t some[kFloats];  // they may be overwritten by those that are kept
    __builtin_memcpy(some, candidates + i, sizeof some);
    lists.add(turn, some, measure<colored>(centre, normal_weight, turn.voxels, some), kFloats);
  }
  if (i < count) {
    std::uint32_t some[kFloats];
    for (std::size_t k = 0; k < kFloats; ++k) some[k] = candidates[i + k < count ? i + k : i];
    lists.add(turn, some, measure<colored>(centre, normal_weight, turn.voxels, some), count - i);
  }
  return lists.claimed;
}

std::size_t find_claims(const Turn& turn, const growth::Distance& distance, const Feature& centre,
                        const std::uint32_t* candidates, std::size_t count, Claim* claims, std::uint32_t* kept) {
  const Split lists{claims, kept};
  return distance.colored ? split<true>(turn, distance.normal_weight, centre, candidates, count, lists)
                          : split<false>(turn, distance.normal_weight, centre, candidates, count, lists);
}

}  // namespace
}  // namespace segserve::SEGSERVE_KERNELS
