// Part of the kernels; see math/lanes.hpp. Planes through weighted neighbours: 8.5 -> 4.6 ms a frame.
#pragma once

#include "segserve/math/lanes.hpp"
#include "segserve/voxel/kernels/kernels.hpp"
#include "segserve/voxel/kernels/moments.hpp"

namespace segserve::SEGSERVE_KERNELS {
namespace {

/// math::exp of single precision.
SEGSERVE_INLINE Float exponential(Float x) {
  const Float scaled = x * 1.44269504F + 0.5F;
  const Int truncated = __builtin_convertvector(scaled, Int);
  const Int n = truncated + (scaled < __builtin_convertvector(truncated, Float));  // "true" is -1
  const Float m = __builtin_convertvector(n, Float);
  const Float r = (x - m * 0.693359375F) - m * -2.12194440e-4F;
  const Float series =
      1.0F + r * (1.0F + r * (1.0F / 2 + r * (1.0F / 6 + r * (1.0F / 24 + r * (1.0F / 120 + r * (1.0F / 720))))));
  return series * reinterpret_cast<Float>((n + 127) << 23);
}

/// Some neighbours of a voxel: their offsets from it (w = 1) and their weights.
struct Neighborhood {
  static constexpr std::size_t kMost = 128;
  Quad offset[kMost];
  alignas(kLaneBytes) float weight[kMost];

  /// As many as the padding of the list fills up.
  SEGSERVE_INLINE void weigh(const RefitInput& input, const RefitTask& task, const std::uint32_t* neighbors,
                             std::size_t count) {
    Quad start = input.centroid[task.voxel];
    start.w = -1;
    const Real4 origin = load<Real4>(&start.x);
    const Quad& n = input.normal[task.voxel];
    std::size_t i = 0;
    for (; i < count; i += kReals) {
      Real4 offsets[kReals], normals[kReals];
#pragma GCC unroll 4
      for (std::size_t k = 0; k < kReals; ++k) {
        const std::uint32_t u = neighbors[i + k];
        offsets[k] = load<Real4>(&input.centroid[u].x) - origin;
        normals[k] = load<Real4>(&input.normal[u].x);
        store(offsets[k], &offset[i + k].x);
      }
      const Columns d = transposed(offsets), m = transposed(normals);
      const Real own = n.x * d.x + n.y * d.y + n.z * d.z;
      const Real other = m.x * d.x + m.y * d.y + m.z * d.z;
      const Real cosine = n.x * m.x + n.y * m.y + n.z * m.z;
      const Real own2 = own * own, other2 = other * other;
      const Real least = other2 < own2 ? other2 : own2;
      // T^2 = 2 (1 - cos T) up to the fourth order.
      const Real exponent = input.angle_scale * (1.0 - cosine) + task.offset_scale * least;
      const Real bounded = exponent > 80.0 ? 80.0 - Real{} : exponent;
      store(__builtin_convertvector(-bounded, HalfFloat), weight + i);
    }
    for (; i % kFloats != 0; ++i) weight[i] = 0;
    for (i = 0; i < count; i += kFloats) store(exponential(load<Float>(weight + i)), weight + i);
  }

  SEGSERVE_INLINE void add_to(MomentLanes& total, std::size_t count) const {
    for (std::size_t i = 0; i < count; ++i) {
      const Real4 d = load<Real4>(&offset[i].x);
      const Real4 weighted = static_cast<double>(weight[i]) * d;
      add({weighted, first(weighted) * second(d), first2(weighted) * second2(d)}, total);
    }
  }
};

/// Weighted moments of a voxel, which is at the origin itself, and of its neighbours; x, y, z and the sum of weights.
SEGSERVE_INLINE MomentLanes weighted_moments(const RefitInput& input, const RefitTask& task) {
  alignas(kLaneBytes) constexpr double kOwn[4] = {0, 0, 0, 1};
  MomentLanes total{};
  total.sum = load<Real4>(kOwn);
  Neighborhood some;
  for (std::size_t first = 0; first < task.count; first += Neighborhood::kMost) {
    const std::size_t count = task.count - first < Neighborhood::kMost ? task.count - first : Neighborhood::kMost;
    some.weigh(input, task, task.neighbors + first, count);
    some.add_to(total, count);
  }
  return total;
}

void refit(const RefitInput& input, const RefitTask* tasks, std::size_t count, Vec3* normals) {
  ScatterBlock block;
  for (std::size_t base = 0; base < count; base += ScatterBlock::kMost) {
    const std::size_t size = count - base < ScatterBlock::kMost ? count - base : ScatterBlock::kMost;
    double weights[ScatterBlock::kMost];
    for (std::size_t i = 0; i < size; ++i) {
      const MomentLanes total = weighted_moments(input, tasks[base + i]);
      weights[i] = pick<3, 3>(total.sum)[0];
      block.set(i, total, weights[i]);
    }
    block.find_normals(size);
    for (std::size_t i = 0; i < size; ++i) {
      const double x = block.x[i], y = block.y[i], z = block.z[i];
      if (weights[i] <= input.support || (x == 0 && y == 0 && z == 0)) continue;
      Vec3& normal = normals[tasks[base + i].voxel];  // the first one, whose side the new one keeps
      const bool other_side = x * normal.x + y * normal.y + z * normal.z < 0;
      normal.x = other_side ? -x : x, normal.y = other_side ? -y : y, normal.z = other_side ? -z : z;
    }
  }
}

}  // namespace
}  // namespace segserve::SEGSERVE_KERNELS
