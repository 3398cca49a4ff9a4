// Part of the kernels; see core/simd/simd_vectors.hpp. Planes through the weighted voxels of windows, eight voxels at a
// time, in single precision relative to a voxel nearby: half the time of refitting to neighbours one by one in double
// precision.
//
// Sums are taken in eight lanes on every CPU, and the lanes are added in one order: the same bytes for any width.
#pragma once

#include "core/normals/simd/normal_kernels.hpp"
#include "core/normals/simd/ring_moments.hpp"
#include "core/simd/simd_vectors.hpp"

namespace segserve::SEGSERVE_KERNELS {
namespace {

inline constexpr std::size_t kLanes = 8;
inline constexpr std::size_t kParts = kLanes / kFloats;  // vectors that hold them
inline constexpr float kNearRange = 3.2F;                // voxels: just beyond the corners of the window
inline constexpr float kLog2E = 1.44269504F;

/// All voxels near a group, relative to its first one.
struct Candidates {
  static constexpr std::size_t kMost = kMostRowSpans * kLanes + kLanes;
  static constexpr std::int32_t kNowhere = -8;
  alignas(kLaneBytes) float x[kMost], y[kMost], z[kMost], nx[kMost], ny[kMost], nz[kMost];
  alignas(kLaneBytes) std::int32_t cell_x[kMost];
  std::size_t count;  // with some that are near no voxel, so that it is a multiple of kLanes

  /// Writes 8 from `at` on, of which the next span overwrites those that are not its own: no branches, and no gathers.
  template <bool with_normals>
  SEGSERVE_INLINE void set(std::size_t at, const WindowColumns& in, std::uint32_t first, const Vec3& origin) {
    const auto offsets = [&](const double* from, double start, float* to) SEGSERVE_INLINE_LAMBDA {
      for (std::size_t k = 0; k < kLanes; k += kReals) {
        store(__builtin_convertvector(load<Real>(from + first + k) - start, HalfFloat), to + at + k);
      }
    };
    const auto copy = [&](const auto* from, auto* to) SEGSERVE_INLINE_LAMBDA {
      for (std::size_t k = 0; k < kLanes; k += kFloats) store(load<Float>(from + first + k), to + at + k);
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
  SEGSERVE_INLINE void collect(const WindowColumns& in, const WindowGroup& group, const RowSpan* spans) {
    const std::uint32_t v = group.voxels.first;
    const Vec3 origin{in.x[v], in.y[v], in.z[v]};
    std::size_t found = 0;
    for (std::size_t i = 0; i < group.span_count; ++i) {
      set<with_normals>(found, in, spans[i].first, origin);
      found += spans[i].count;
    }
    // The rest of the last kLanes are near no voxel. All of their numbers: what the stack holds may be none, and 0
    // times that is none either.
    for (std::size_t k = 0; k < kLanes; k += kFloats) {
      float* const columns[] = {x, y, z, nx, ny, nz};
      for (float* column : columns) store(Float{}, column + found + k);
      store(Int{} + kNowhere, cell_x + found + k);
    }
    count = (found + kLanes - 1) / kLanes * kLanes;
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

/// kFloats of the candidates as seen from a voxel.
struct Near {
  const Candidates& of;
  std::size_t at;
  Float dx, dy, dz;
};

/// Weighted moments of the candidates in the window around voxel v, about its centroid; w of `sum` is the sum of
/// weights. `weigh`: of a Near.
template <typename Weigh>
SEGSERVE_INLINE MomentLanes weighted_moments(const WindowColumns& in, std::uint32_t origin, std::uint32_t v,
                                             const Candidates& near, Weigh&& weigh) {
  const float x = static_cast<float>(in.x[v] - in.x[origin]), y = static_cast<float>(in.y[v] - in.y[origin]),
              z = static_cast<float>(in.z[v] - in.z[origin]);
  const std::int32_t left = in.cell_x[v] - 3, right = in.cell_x[v] + 3;
  Float sum_w[kParts]{}, sum_x[kParts]{}, sum_y[kParts]{}, sum_z[kParts]{}, xx[kParts]{}, xy[kParts]{}, xz[kParts]{},
      yy[kParts]{}, yz[kParts]{}, zz[kParts]{};
  for (std::size_t base = 0; base < near.count; base += kLanes) {
#pragma GCC unroll 2
    for (std::size_t part = 0; part < kParts; ++part) {
      const std::size_t at = base + part * kFloats;
      const Float dx = load<Float>(near.x + at) - x, dy = load<Float>(near.y + at) - y,
                  dz = load<Float>(near.z + at) - z;
      const Int cell = load<Int>(near.cell_x + at);
      const Int in_window = (cell > left) & (cell < right);
      const Float w = reinterpret_cast<Float>(reinterpret_cast<Int>(weigh(Near{near, at, dx, dy, dz})) & in_window);
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

/// (1 - (d / kNearRange)^2)^2 of the distance d in voxels, 0 beyond.
struct NearWeight {
  float scale;

  SEGSERVE_INLINE NearWeight(const WindowColumns& in, std::uint32_t v)
      : scale(in.inverse_square_edge[v] * (1 / (kNearRange * kNearRange))) {}

  SEGSERVE_INLINE Float operator()(const Near& u) const {
    const Float rest = 1.0F - scale * (u.dx * u.dx + u.dy * u.dy + u.dz * u.dz);
    const Float positive = rest > 0.0F ? rest : Float{};
    return positive * positive;
  }
};

/// Of voxels whose normals are similar, and one of which lies in the plane of the other.
struct EdgeAwareWeight {
  float nx, ny, nz, angle_scale, offset_scale;

  SEGSERVE_INLINE EdgeAwareWeight(const WindowColumns& in, const RefitScales& scales, std::uint32_t v)
      : nx(in.nx[v]),
        ny(in.ny[v]),
        nz(in.nz[v]),
        angle_scale(scales.angle * kLog2E),
        offset_scale(scales.offset * kLog2E * in.inverse_square_edge[v]) {}

  SEGSERVE_INLINE Float operator()(const Near& u) const {
    const Float mx = load<Float>(u.of.nx + u.at), my = load<Float>(u.of.ny + u.at), mz = load<Float>(u.of.nz + u.at);
    const Float own = nx * u.dx + ny * u.dy + nz * u.dz;
    const Float other = mx * u.dx + my * u.dy + mz * u.dz;
    const Float cosine = nx * mx + ny * my + nz * mz;
    const Float own2 = own * own, other2 = other * other;
    const Float least = other2 < own2 ? other2 : own2;
    return power_of_2(angle_scale * (cosine - 1.0F) - offset_scale * least);
  }
};

/// Voxels whose weighted moments are known, on their way to their normals.
struct WindowBlock {
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
};

/// set(block) for blocks of the groups' voxels whose normals were found. `weight_of`: of a voxel.
template <bool with_normals, typename WeightOf, typename Set>
SEGSERVE_INLINE void for_fitted(const WindowColumns& in, const WindowGroups& groups, WeightOf&& weight_of, Set&& set) {
  WindowBlock block;
  Candidates near;
  const auto empty = [&]() SEGSERVE_INLINE_LAMBDA {
    block.scatter.find_normals(block.count);
    for (std::size_t i = 0; i < block.count; ++i) set(block, i);
    block.count = 0;
  };
  for (const WindowGroup* group = groups.begin; group < groups.end; ++group) {
    if (block.count + WindowGroup::kMost > WindowBlock::kMost) empty();
    near.collect<with_normals>(in, *group, groups.spans + group->first_span);
    const std::uint32_t first = group->voxels.first;
    for (std::uint32_t v = first; v < first + group->voxels.count; ++v) {
      block.add(v, weighted_moments(in, first, v, near, weight_of(v)));
    }
  }
  empty();
}

void fit_windows(const WindowColumns& columns, const WindowGroups& groups, Vec3* normals) {
  for_fitted<false>(
      columns, groups, [&](std::uint32_t v) SEGSERVE_INLINE_LAMBDA { return NearWeight(columns, v); },
      [&](const WindowBlock& block, std::size_t i) SEGSERVE_INLINE_LAMBDA {
        Vec3& normal = normals[block.voxel[i]];
        normal.x = block.scatter.x[i], normal.y = block.scatter.y[i], normal.z = block.scatter.z[i];
      });
}

/// A new normal keeps the side of the first one.
void refit_windows(const WindowColumns& columns, const RefitScales& scales, const WindowGroups& groups, Vec3* normals) {
  for_fitted<true>(
      columns, groups, [&](std::uint32_t v) SEGSERVE_INLINE_LAMBDA { return EdgeAwareWeight(columns, scales, v); },
      [&](const WindowBlock& block, std::size_t i) SEGSERVE_INLINE_LAMBDA {
        const double x = block.scatter.x[i], y = block.scatter.y[i], z = block.scatter.z[i];
        if (block.weight[i] <= scales.support || (x == 0 && y == 0 && z == 0)) return;
        Vec3& normal = normals[block.voxel[i]];
        const bool other_side = x * normal.x + y * normal.y + z * normal.z < 0;
        normal.x = other_side ? -x : x, normal.y = other_side ? -y : y, normal.z = other_side ? -z : z;
      });
}

}  // namespace
}  // namespace segserve::SEGSERVE_KERNELS
