// Part of the kernels; see math/lanes.hpp. Planes through weighted neighbours, eight neighbours at a time, in single
// precision relative to a voxel nearby: with the rows that edge_aware_normals.cpp finds, refining takes half the time.
//
// Sums are taken in eight lanes on every CPU, and the lanes are added in one order: the same bytes for any width.
#pragma once

#include "segserve/math/lanes.hpp"
#include "segserve/voxel/kernels/kernels.hpp"
#include "segserve/voxel/kernels/moments.hpp"

namespace segserve::SEGSERVE_KERNELS {
namespace {

inline constexpr std::size_t kLanes = 8;
inline constexpr std::size_t kParts = kLanes / kFloats;  // vectors that hold them
inline constexpr float kLog2E = 1.44269504F;

/// All voxels near a group, relative to its first one.
struct Candidates {
  static constexpr std::size_t kMost = kMostRowSpans * kLanes + kLanes;
  static constexpr std::int32_t kNowhere = -8;
  alignas(kLaneBytes) float x[kMost], y[kMost], z[kMost], nx[kMost], ny[kMost], nz[kMost];
  alignas(kLaneBytes) std::int32_t cell_x[kMost];

  /// Writes 8 from `at` on, of which the next span overwrites those that are not its own: no branches, and no gathers.
  SEGSERVE_INLINE void set(std::size_t at, const RefitInput& in, std::uint32_t first, const Vec3& origin) {
    const auto offsets = [&](const double* from, double start, float* to) SEGSERVE_INLINE_LAMBDA {
      for (std::size_t k = 0; k < kLanes; k += kReals) {
        store(__builtin_convertvector(load<Real>(from + first + k) - start, HalfFloat), to + at + k);
      }
    };
    const auto copy = [&](const auto* from, auto* to)
                          SEGSERVE_INLINE_LAMBDA { __builtin_memcpy(to + at, from + first, kLanes * sizeof *to); };
    offsets(in.x, origin.x, x);
    offsets(in.y, origin.y, y);
    offsets(in.z, origin.z, z);
    copy(in.nx, nx);
    copy(in.ny, ny);
    copy(in.nz, nz);
    copy(in.cell_x, cell_x);
  }

  /// Returns their number, with some that are near no voxel so that it is a multiple of kLanes.
  SEGSERVE_INLINE std::size_t collect(const RefitInput& in, const RefitGroup& group) {
    const std::uint32_t v = group.voxels.first;
    const Vec3 origin{in.x[v], in.y[v], in.z[v]};
    std::size_t count = 0;
    for (std::size_t i = 0; i < group.span_count; ++i) {
      set(count, in, group.spans[i].first, origin);
      count += group.spans[i].count;
    }
    // All of them: what the stack holds may be no number, and 0 times that is none.
    for (; count % kLanes != 0; ++count) {
      x[count] = y[count] = z[count] = nx[count] = ny[count] = nz[count] = 0;
      cell_x[count] = kNowhere;
    }
    return count;
  }
};

using Float4 = float __attribute__((vector_size(16)));

/// Lane i + 4 added to lane i.
SEGSERVE_INLINE Float4 folded(const Float (&parts)[kParts]) {
#if defined(__AVX2__)
  return __builtin_shufflevector(parts[0], parts[0], 0, 1, 2, 3) +
         __builtin_shufflevector(parts[0], parts[0], 4, 5, 6, 7);
#else
  return parts[0] + parts[1];
#endif
}

/// The sums of the lanes of four things.
SEGSERVE_INLINE Real4 sums(Float4 a, Float4 b, Float4 c, Float4 d) {
  const Float4 ab = __builtin_shufflevector(a, b, 0, 4, 1, 5) + __builtin_shufflevector(a, b, 2, 6, 3, 7);
  const Float4 cd = __builtin_shufflevector(c, d, 0, 4, 1, 5) + __builtin_shufflevector(c, d, 2, 6, 3, 7);
  const Float4 sum = __builtin_shufflevector(ab, cd, 0, 1, 4, 5) + __builtin_shufflevector(ab, cd, 2, 3, 6, 7);
#if defined(__AVX2__)
  return __builtin_convertvector(sum, Real4);
#else
  const Real2 low{sum[0], sum[1]}, high{sum[2], sum[3]};
  return {low, high};
#endif
}

/// 2^x for x up to 0 and a little more, within 3e-6 of it; below -120, as there. The sum with kShift rounds, and leaves
/// the integer in its lowest bits, from where it moves into the exponent: two thirds of the operations of math::exp.
SEGSERVE_INLINE Float power_of_2(Float x) {
  constexpr float kLeast = -120, kShift = 12582912;  // 1.5 * 2^23
  const Float bounded = x < kLeast ? kLeast - Float{} : x;
  const Float shifted = bounded + kShift;
  const Float f = bounded - (shifted - kShift);
  const Float series =
      1.0F + f * (0.69314718F + f * (0.24022651F + f * (0.055504109F + f * (0.0096181291F + f * 0.0013333558F))));
  return reinterpret_cast<Float>(reinterpret_cast<Int>(series) + (reinterpret_cast<Int>(shifted) << 23));
}

/// Weighted moments of the candidates around voxel i of the group, about its centroid; w of `sum` is the sum of
/// weights.
SEGSERVE_INLINE MomentLanes weighted_moments(const RefitInput& in, const RefitGroup& group, std::size_t i,
                                             const Candidates& near, std::size_t count) {
  const std::uint32_t first = group.voxels.first, v = first + static_cast<std::uint32_t>(i);
  const float x = static_cast<float>(in.x[v] - in.x[first]), y = static_cast<float>(in.y[v] - in.y[first]),
              z = static_cast<float>(in.z[v] - in.z[first]), nx = in.nx[v], ny = in.ny[v], nz = in.nz[v];
  const std::int32_t left = in.cell_x[v] - 3, right = in.cell_x[v] + 3;
  const float angle_scale = in.angle_scale * kLog2E, offset_scale = group.offset_scale[i] * kLog2E;
  Float sum_w[kParts]{}, sum_x[kParts]{}, sum_y[kParts]{}, sum_z[kParts]{}, xx[kParts]{}, xy[kParts]{}, xz[kParts]{},
      yy[kParts]{}, yz[kParts]{}, zz[kParts]{};
  for (std::size_t base = 0; base < count; base += kLanes) {
#pragma GCC unroll 2
    for (std::size_t part = 0; part < kParts; ++part) {
      const std::size_t at = base + part * kFloats;
      const Float dx = load<Float>(near.x + at) - x, dy = load<Float>(near.y + at) - y,
                  dz = load<Float>(near.z + at) - z;
      const Float mx = load<Float>(near.nx + at), my = load<Float>(near.ny + at), mz = load<Float>(near.nz + at);
      const Float own = nx * dx + ny * dy + nz * dz;
      const Float other = mx * dx + my * dy + mz * dz;
      const Float cosine = nx * mx + ny * my + nz * mz;
      const Float own2 = own * own, other2 = other * other;
      const Float least = other2 < own2 ? other2 : own2;
      const Int cell = load<Int>(near.cell_x + at);
      const Int used = (cell > left) & (cell < right);
      const Float weight = power_of_2(angle_scale * (cosine - 1.0F) - offset_scale * least);
      const Float w = reinterpret_cast<Float>(reinterpret_cast<Int>(weight) & used);
      const Float wx = w * dx, wy = w * dy, wz = w * dz;
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
  MomentLanes total;
  total.sum = sums(folded(sum_x), folded(sum_y), folded(sum_z), folded(sum_w));
  total.square = sums(folded(xx), folded(xy), folded(xz), folded(yy));
  total.square2 = pick<0, 1>(sums(folded(yz), folded(zz), none, none));
  return total;
}

/// Voxels whose weighted moments are known, on their way to their normals.
struct RefitBlock {
  static constexpr std::size_t kMost = ScatterBlock::kMost;
  ScatterBlock scatter;
  double weight[kMost];
  std::uint32_t voxel[kMost];
  std::size_t count = 0;

  SEGSERVE_INLINE void add(std::uint32_t v, const MomentLanes& moments) {
    voxel[count] = v;
    weight[count] = pick<2, 3>(moments.sum)[1];
    scatter.set(count, moments, weight[count]);
    ++count;
  }

  /// A new normal keeps the side of the first one.
  void find_normals(double support, Vec3* normals) {
    scatter.find_normals(count);
    for (std::size_t i = 0; i < count; ++i) {
      const double x = scatter.x[i], y = scatter.y[i], z = scatter.z[i];
      if (weight[i] <= support || (x == 0 && y == 0 && z == 0)) continue;
      Vec3& normal = normals[voxel[i]];
      const bool other_side = x * normal.x + y * normal.y + z * normal.z < 0;
      normal.x = other_side ? -x : x, normal.y = other_side ? -y : y, normal.z = other_side ? -z : z;
    }
    count = 0;
  }
};

void refit(const RefitInput& input, const RefitGroup* groups, std::size_t count, Vec3* normals) {
  RefitBlock block;
  Candidates near;
  for (const RefitGroup* group = groups; group < groups + count; ++group) {
    if (block.count + RefitGroup::kMost > RefitBlock::kMost) block.find_normals(input.support, normals);
    const std::size_t candidates = near.collect(input, *group);
    for (std::size_t i = 0; i < group->voxels.count; ++i) {
      block.add(group->voxels.first + static_cast<std::uint32_t>(i),
                weighted_moments(input, *group, i, near, candidates));
    }
  }
  block.find_normals(input.support, normals);
}

}  // namespace
}  // namespace segserve::SEGSERVE_KERNELS
