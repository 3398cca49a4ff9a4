// SPDX-License-Identifier: Apache-2.0
// Kernels; see core/simd/simd_vectors.hpp. Fits planes to the weighted voxels of neighborhoods, eight voxels at a time,
// in single precision relative to a voxel nearby.
//
// Every target sums up in eight lanes and adds the lanes in the same order. So sums have the same bytes for any width.
#pragma once

#include "core/normals/simd/normal_kernels.hpp"
#include "core/normals/simd/ring_moments.hpp"
#include "core/simd/simd_vectors.hpp"

namespace segserve::SEGSERVE_SIMD_TARGET {
namespace {

inline constexpr std::size_t kLanes = 8;
inline constexpr std::size_t kVectors = kLanes / kFloatLanes;  // vectors that hold kLanes floats
inline constexpr float kNearRange = 3.2F;                      // in voxels: just beyond the corners of the neighborhood
inline constexpr float kLog2E = 1.44269504F;

/// All voxels near a group, relative to its first voxel.
struct NearbyVoxels {
  static constexpr std::size_t kMost = kMostRowSpans * kLanes + kLanes;
  static constexpr std::int32_t kNowhere = -8;
  alignas(kVectorBytes) float x[kMost], y[kMost], z[kMost], nx[kMost], ny[kMost], nz[kMost];
  alignas(kVectorBytes) std::int32_t cell_x[kMost];
  std::size_t count;  // a multiple of kLanes, because padding counts

  /// Writes kLanes voxels from `at` on. The next span overwrites those that are not of this one. So there are neither
  /// branches nor gathers.
  template <bool with_normals>
  SEGSERVE_INLINE void set(std::size_t at, const VoxelColumns& in, std::uint32_t first, const Vec3& origin) {
    const auto offsets = [&](const double* from, double start, float* to) SEGSERVE_INLINE_LAMBDA {
      for (std::size_t k = 0; k < kLanes; k += kDoubleLanes) {
        store(__builtin_convertvector(load<Doubles>(from + first + k) - start, HalfFloats), to + at + k);
      }
    };
    const auto copy = [&](const auto* from, auto* to) SEGSERVE_INLINE_LAMBDA {
      for (std::size_t k = 0; k < kLanes; k += kFloatLanes) store(load<Floats>(from + first + k), to + at + k);
    };
    offsets(in.x, origin.x, x);
    offsets(in.y, origin.y, y);
    offsets(in.z, origin.z, z);
    if constexpr (with_normals) {
      copy(in.nx, nx);
      copy(in.ny, ny);
      copy(in.nz, nz);
    }
    copy(in.cell_x, cell_x);
  }

  template <bool with_normals>
  SEGSERVE_INLINE void collect(const VoxelColumns& in, const VoxelGroup& group, const RowSpan* spans) {
    const std::uint32_t v = group.voxels.first;
    const Vec3 origin{in.x[v], in.y[v], in.z[v]};
    std::size_t found = 0;
    for (std::size_t i = 0; i < group.span_count; ++i) {
      set<with_normals>(found, in, spans[i].first, origin);
      found += spans[i].count;
    }
    // The last kLanes are padded by voxels that are near no other. The padding is zeroed: uninitialized floats may be
    // NaN, and 0 * NaN is NaN.
    for (std::size_t k = 0; k < kLanes; k += kFloatLanes) {
      float* const columns[] = {x, y, z, nx, ny, nz};
      for (float* column : columns) store(Floats{}, column + found + k);
      store(Ints{} + kNowhere, cell_x + found + k);
    }
    count = (found + kLanes - 1) / kLanes * kLanes;
  }
};

using Float4 = float __attribute__((vector_size(16)));

/// Adds lane i + 4 to lane i.
SEGSERVE_INLINE Float4 fold(const Floats (&parts)[kVectors]) {
#if defined(__AVX2__)
  return __builtin_shufflevector(parts[0], parts[0], 0, 1, 2, 3) +
         __builtin_shufflevector(parts[0], parts[0], 4, 5, 6, 7);
#else
  return parts[0] + parts[1];
#endif
}

/// The sum of the lanes of each vector.
SEGSERVE_INLINE Double4 sums(Float4 a, Float4 b, Float4 c, Float4 d) {
  const Float4 ab = __builtin_shufflevector(a, b, 0, 4, 1, 5) + __builtin_shufflevector(a, b, 2, 6, 3, 7);
  const Float4 cd = __builtin_shufflevector(c, d, 0, 4, 1, 5) + __builtin_shufflevector(c, d, 2, 6, 3, 7);
  const Float4 sum = __builtin_shufflevector(ab, cd, 0, 1, 4, 5) + __builtin_shufflevector(ab, cd, 2, 3, 6, 7);
#if defined(__AVX2__)
  return __builtin_convertvector(sum, Double4);
#else
  const Double2 low{sum[0], sum[1]}, high{sum[2], sum[3]};
  return {low, high};
#endif
}

/// 2^x, within 3e-6 of it, for x that is hardly above 0; where x is below -120 it counts as that. Adding kShift rounds
/// x, and leaves the integer in the lowest bits of the sum, from where it moves into the exponent.
SEGSERVE_INLINE Floats power_of_2(Floats x) {
  constexpr float kLeast = -120, kShift = 12582912;  // 1.5 * 2^23
  const Floats bounded = x < kLeast ? kLeast - Floats{} : x;
  const Floats shifted = bounded + kShift;
  const Floats f = bounded - (shifted - kShift);
  const Floats series =
      1.0F + f * (0.69314718F + f * (0.24022651F + f * (0.055504109F + f * (0.0096181291F + f * 0.0013333558F))));
  return reinterpret_cast<Floats>(reinterpret_cast<Ints>(series) + (reinterpret_cast<Ints>(shifted) << 23));
}

/// kFloatLanes of the nearby voxels, relative to a voxel.
struct NearbyVector {
  const NearbyVoxels& voxels;
  std::size_t at;
  Floats dx, dy, dz;
};

/// Weighted moments of the neighborhood of voxel v, relative to its centroid. The fourth lane of `sum` is the sum of
/// weights. weigh(vector) gives the weights of a NearbyVector.
template <typename Weigh>
SEGSERVE_INLINE Moments weighted_moments(const VoxelColumns& in, std::uint32_t origin, std::uint32_t v,
                                         const NearbyVoxels& near, Weigh&& weigh) {
  const float x = static_cast<float>(in.x[v] - in.x[origin]), y = static_cast<float>(in.y[v] - in.y[origin]),
              z = static_cast<float>(in.z[v] - in.z[origin]);
  const std::int32_t left = in.cell_x[v] - 3, right = in.cell_x[v] + 3;
  Floats sum_w[kVectors]{}, sum_x[kVectors]{}, sum_y[kVectors]{}, sum_z[kVectors]{}, xx[kVectors]{}, xy[kVectors]{},
      xz[kVectors]{}, yy[kVectors]{}, yz[kVectors]{}, zz[kVectors]{};
  for (std::size_t base = 0; base < near.count; base += kLanes) {
#pragma GCC unroll 2
    for (std::size_t part = 0; part < kVectors; ++part) {
      const std::size_t at = base + part * kFloatLanes;
      const Floats dx = load<Floats>(near.x + at) - x, dy = load<Floats>(near.y + at) - y,
                   dz = load<Floats>(near.z + at) - z;
      const Ints cell = load<Ints>(near.cell_x + at);
      const Ints in_neighborhood = (cell > left) & (cell < right);
      const Floats w =
          reinterpret_cast<Floats>(reinterpret_cast<Ints>(weigh(NearbyVector{near, at, dx, dy, dz})) & in_neighborhood);
      const Floats wx = w * dx, wy = w * dy, wz = w * dz;
      sum_w[part] += w;
      sum_x[part] += wx;
      sum_y[part] += wy;
      sum_z[part] += wz;
      xx[part] += wx * dx;
      xy[part] += wx * dy;
      xz[part] += wx * dz;
      yy[part] += wy * dy;
      yz[part] += wy * dz;
      zz[part] += wz * dz;
    }
  }
  const Float4 none{};
  Moments total;
  total.sum = sums(fold(sum_x), fold(sum_y), fold(sum_z), fold(sum_w));
  total.square = sums(fold(xx), fold(xy), fold(xz), fold(yy));
  total.square2 = pick<0, 1>(sums(fold(yz), fold(zz), none, none));
  return total;
}

/// The weight (1 - (d / kNearRange)^2)^2 of the distance d, in voxels, or 0 beyond kNearRange.
struct NearWeight {
  float scale;

  SEGSERVE_INLINE NearWeight(const VoxelColumns& in, std::uint32_t v)
      : scale(in.inverse_square_edge[v] * (1 / (kNearRange * kNearRange))) {}

  SEGSERVE_INLINE Floats operator()(const NearbyVector& u) const {
    const Floats rest = 1.0F - scale * (u.dx * u.dx + u.dy * u.dy + u.dz * u.dz);
    const Floats positive = rest > 0.0F ? rest : Floats{};
    return positive * positive;
  }
};

/// The weight of EdgeAwareNormals. It is high for voxels whose normals are similar, and one of which lies in the plane
/// of the other.
struct EdgeAwareWeight {
  float nx, ny, nz, angle_scale, offset_scale;

  SEGSERVE_INLINE EdgeAwareWeight(const VoxelColumns& in, const RefitScales& scales, std::uint32_t v)
      : nx(in.nx[v]),
        ny(in.ny[v]),
        nz(in.nz[v]),
        angle_scale(scales.angle * kLog2E),
        offset_scale(scales.offset * kLog2E * in.inverse_square_edge[v]) {}

  SEGSERVE_INLINE Floats operator()(const NearbyVector& u) const {
    const Floats mx = load<Floats>(u.voxels.nx + u.at), my = load<Floats>(u.voxels.ny + u.at),
                 mz = load<Floats>(u.voxels.nz + u.at);
    const Floats own = nx * u.dx + ny * u.dy + nz * u.dz;
    const Floats other = mx * u.dx + my * u.dy + mz * u.dz;
    const Floats cosine = nx * mx + ny * my + nz * mz;
    const Floats own2 = own * own, other2 = other * other;
    const Floats least = other2 < own2 ? other2 : own2;
    return power_of_2(angle_scale * (cosine - 1.0F) - offset_scale * least);
  }
};

/// Voxels whose weighted moments are known, and whose normals are found together.
struct FitBlock {
  static constexpr std::size_t kMost = ScatterBlock::kMost;
  ScatterBlock scatter;
  double weight[kMost];
  std::uint32_t voxel[kMost];
  std::size_t count = 0;

  SEGSERVE_INLINE void add(std::uint32_t v, const Moments& moments) {
    voxel[count] = v;
    weight[count] = pick<2, 3>(moments.sum)[1];
    scatter.set(count, moments, weight[count]);
    ++count;
  }
};

/// Calls set(block, i) for the voxels of the groups, with the normals that were found by the weights weight_of(voxel).
template <bool with_normals, typename WeightOf, typename Set>
SEGSERVE_INLINE void for_each_fit(const VoxelColumns& in, const VoxelGroups& groups, WeightOf&& weight_of, Set&& set) {
  FitBlock block;
  NearbyVoxels near;
  const auto empty = [&]() SEGSERVE_INLINE_LAMBDA {
    block.scatter.find_normals(block.count);
    for (std::size_t i = 0; i < block.count; ++i) set(block, i);
    block.count = 0;
  };
  for (const VoxelGroup* group = groups.begin; group < groups.end; ++group) {
    if (block.count + VoxelGroup::kMost > FitBlock::kMost) empty();
    near.collect<with_normals>(in, *group, groups.spans + group->first_span);
    const std::uint32_t first = group->voxels.first;
    for (std::uint32_t v = first; v < first + group->voxels.count; ++v) {
      block.add(v, weighted_moments(in, first, v, near, weight_of(v)));
    }
  }
  empty();
}

void fit_neighborhoods(const VoxelColumns& columns, const VoxelGroups& groups, Vec3* normals) {
  for_each_fit<false>(
      columns, groups, [&](std::uint32_t v) SEGSERVE_INLINE_LAMBDA { return NearWeight(columns, v); },
      [&](const FitBlock& block, std::size_t i) SEGSERVE_INLINE_LAMBDA {
        Vec3& normal = normals[block.voxel[i]];
        normal.x = block.scatter.x[i], normal.y = block.scatter.y[i], normal.z = block.scatter.z[i];
      });
}

/// A new normal has the side of the first one.
void refit_neighborhoods(const VoxelColumns& columns, const RefitScales& scales, const VoxelGroups& groups,
                         Vec3* normals) {
  for_each_fit<true>(
      columns, groups, [&](std::uint32_t v) SEGSERVE_INLINE_LAMBDA { return EdgeAwareWeight(columns, scales, v); },
      [&](const FitBlock& block, std::size_t i) SEGSERVE_INLINE_LAMBDA {
        const double x = block.scatter.x[i], y = block.scatter.y[i], z = block.scatter.z[i];
        if (block.weight[i] <= scales.support || (x == 0 && y == 0 && z == 0)) return;
        Vec3& normal = normals[block.voxel[i]];
        const bool other_side = x * normal.x + y * normal.y + z * normal.z < 0;
        normal.x = other_side ? -x : x, normal.y = other_side ? -y : y, normal.z = other_side ? -z : z;
      });
}

}  // namespace
}  // namespace segserve::SEGSERVE_SIMD_TARGET
