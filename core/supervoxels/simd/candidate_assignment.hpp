// SPDX-License-Identifier: Apache-2.0
// A kernel; see core/simd/simd_vectors.hpp. Measures the distances of candidates to the center of a cluster, and
// assigns those that are nearer to it than to the center of their own cluster.
#pragma once

#include "core/simd/simd_vectors.hpp"
#include "core/supervoxels/simd/growth_kernels.hpp"

namespace segserve::SEGSERVE_SIMD_TARGET {
namespace {

using growth::AssignedVoxel;
using growth::DistanceWeights;
using growth::Expansion;
using growth::Feature;
using growth::Voxel;

// Voxels are read as rows of twelve floats: the nine of the feature, the distance, and two that are not used.
static_assert(__builtin_offsetof(Voxel, feature) == 0);
static_assert(__builtin_offsetof(Voxel, distance) == Feature::kSize * sizeof(float));
static_assert(sizeof(Voxel) >= 12 * sizeof(float));

/// Four consecutive floats of as many voxels as a vector has lanes, each in a vector of its own.
struct FourColumns {
  Floats a, b, c, d;
};

/// The floats `first` to `first` + 3 of the rows.
SEGSERVE_INLINE FourColumns load_columns(const unsigned char* const (&rows)[kFloatLanes], std::size_t first) {
  const auto row = [&](std::size_t i) SEGSERVE_INLINE_LAMBDA { return rows[i] + first * sizeof(float); };
#if defined(__AVX2__)
  const auto two_rows = [&](std::size_t i) SEGSERVE_INLINE_LAMBDA {
    return __builtin_shufflevector(load<HalfFloats>(row(i)), load<HalfFloats>(row(i + 4)), 0, 1, 2, 3, 4, 5, 6, 7);
  };
  const Floats r0 = two_rows(0), r1 = two_rows(1), r2 = two_rows(2), r3 = two_rows(3);
  const Floats low01 = __builtin_shufflevector(r0, r1, 0, 8, 1, 9, 4, 12, 5, 13);
  const Floats high01 = __builtin_shufflevector(r0, r1, 2, 10, 3, 11, 6, 14, 7, 15);
  const Floats low23 = __builtin_shufflevector(r2, r3, 0, 8, 1, 9, 4, 12, 5, 13);
  const Floats high23 = __builtin_shufflevector(r2, r3, 2, 10, 3, 11, 6, 14, 7, 15);
  return {__builtin_shufflevector(low01, low23, 0, 1, 8, 9, 4, 5, 12, 13),
          __builtin_shufflevector(low01, low23, 2, 3, 10, 11, 6, 7, 14, 15),
          __builtin_shufflevector(high01, high23, 0, 1, 8, 9, 4, 5, 12, 13),
          __builtin_shufflevector(high01, high23, 2, 3, 10, 11, 6, 7, 14, 15)};
#else
  const Floats r0 = load<Floats>(row(0)), r1 = load<Floats>(row(1)), r2 = load<Floats>(row(2)),
               r3 = load<Floats>(row(3));
  const Floats low01 = __builtin_shufflevector(r0, r1, 0, 4, 1, 5);
  const Floats high01 = __builtin_shufflevector(r0, r1, 2, 6, 3, 7);
  const Floats low23 = __builtin_shufflevector(r2, r3, 0, 4, 1, 5);
  const Floats high23 = __builtin_shufflevector(r2, r3, 2, 6, 3, 7);
  return {__builtin_shufflevector(low01, low23, 0, 1, 4, 5), __builtin_shufflevector(low01, low23, 2, 3, 6, 7),
          __builtin_shufflevector(high01, high23, 0, 1, 4, 5), __builtin_shufflevector(high01, high23, 2, 3, 6, 7)};
#endif
}

struct MeasuredVoxels {
  Floats distance;  // to the center
  Ints nearer;      // masks the voxels that are nearer to it than to the center of their own cluster
};

/// The distance of VCCS (SupervoxelGrowth) of as many voxels as a vector has lanes.
template <bool colored>
SEGSERVE_INLINE MeasuredVoxels measure(const Feature& center, float normal_weight, const Voxel* voxels,
                                       const std::uint32_t* indices) {
  const unsigned char* rows[kFloatLanes];
  for (std::size_t i = 0; i < kFloatLanes; ++i) rows[i] = reinterpret_cast<const unsigned char*>(voxels + indices[i]);
  const auto [px, py, pz, nx] = load_columns(rows, Feature::kX);
  const auto [ny, nz, red, green] = load_columns(rows, Feature::kNormalY);
  const auto [blue, own_distance, unused1, unused2] = load_columns(rows, Feature::kBlue);
  const float* const c = center.value;
  const Floats x = c[Feature::kX] - px, y = c[Feature::kY] - py, z = c[Feature::kZ] - pz;
  Floats distance = square_root(x * x + y * y + z * z);
  if constexpr (colored) {
    const Floats r = c[Feature::kRed] - red, g = c[Feature::kGreen] - green, b = c[Feature::kBlue] - blue;
    distance = distance + square_root(r * r + g * g + b * b);
  }
  const Floats cosine = c[Feature::kNormalX] * nx + c[Feature::kNormalY] * ny + c[Feature::kNormalZ] * nz;
  const Floats absolute = reinterpret_cast<Floats>(reinterpret_cast<Ints>(cosine) & 0x7fffffff);
  distance = distance + normal_weight * (1.0F - absolute);
  return {distance, distance < own_distance};
}

/// Divides candidates among two lists.
struct CandidateLists {
  AssignedVoxel* assigned;
  std::uint32_t* kept;
  std::size_t assigned_count = 0, kept_count = 0;

  /// Adds the voxels in the first `count` lanes. There are no branches, because which list a candidate belongs to is
  /// hard to predict.
  SEGSERVE_INLINE void add(const Expansion& expansion, const std::uint32_t* indices, const MeasuredVoxels& measured,
                           std::size_t count) {
    alignas(kVectorBytes) float distance[kFloatLanes];
    alignas(kVectorBytes) std::int32_t nearer[kFloatLanes];
    store(measured.distance, distance);
    store(measured.nearer, nearer);
#pragma GCC unroll 8
    for (std::size_t i = 0; i < count; ++i) {
      const std::uint32_t u = indices[i];
      expansion.voxels[u].visited_in = expansion.number;
      assigned[assigned_count].voxel = u;
      assigned[assigned_count].distance = distance[i];
      kept[kept_count] = u;
      const auto is_nearer = static_cast<std::size_t>(nearer[i] & 1);
      assigned_count += is_nearer;
      kept_count += 1 - is_nearer;
    }
  }
};

template <bool colored>
SEGSERVE_INLINE std::size_t assign(const Expansion& expansion, float normal_weight, const Feature center,
                                   const std::uint32_t* candidates, std::size_t count, CandidateLists lists) {
  std::size_t i = 0;
  for (; i + kFloatLanes <= count; i += kFloatLanes) {
    std::uint32_t some[kFloatLanes];  // a copy, because the kept ones may overwrite them
    __builtin_memcpy(some, candidates + i, sizeof some);
    lists.add(expansion, some, measure<colored>(center, normal_weight, expansion.voxels, some), kFloatLanes);
  }
  if (i < count) {
    std::uint32_t some[kFloatLanes];
    for (std::size_t k = 0; k < kFloatLanes; ++k) some[k] = candidates[i + k < count ? i + k : i];
    lists.add(expansion, some, measure<colored>(center, normal_weight, expansion.voxels, some), count - i);
  }
  return lists.assigned_count;
}

std::size_t assign_candidates(const Expansion& expansion, const DistanceWeights& weights, const Feature& center,
                              const std::uint32_t* candidates, std::size_t count, AssignedVoxel* assigned,
                              std::uint32_t* kept) {
  const CandidateLists lists{assigned, kept};
  return weights.colored ? assign<true>(expansion, weights.normal, center, candidates, count, lists)
                         : assign<false>(expansion, weights.normal, center, candidates, count, lists);
}

}  // namespace
}  // namespace segserve::SEGSERVE_SIMD_TARGET
