// SPDX-License-Identifier: Apache-2.0
// Kernels; see core/simd/simd_vectors.hpp. Computes the moments of rings of neighbors, with x, y and z in lanes, and
// fits planes to them.
#pragma once

#include "core/normals/simd/normal_kernels.hpp"
#include "core/normals/simd/smallest_eigenvector.hpp"
#include "core/simd/simd_vectors.hpp"

namespace segserve::SEGSERVE_SIMD_TARGET {
namespace {

// The six products of a symmetric matrix are first(v) * second(v), that is xx, xy, xz and yy, and
// first2(v) * second2(v), that is yz and zz.
SEGSERVE_INLINE Double4 first(Double4 v) { return shuffle<0, 0, 0, 1>(v); }
SEGSERVE_INLINE Double4 second(Double4 v) { return shuffle<0, 1, 2, 1>(v); }
SEGSERVE_INLINE Double2 first2(Double4 v) { return pick<1, 2>(v); }
SEGSERVE_INLINE Double2 second2(Double4 v) { return pick<2, 2>(v); }

struct Moments {
  Double4 sum;      // x, y, z, count
  Double4 square;   // xx, xy, xz, yy
  Double2 square2;  // yz, zz
};

SEGSERVE_INLINE Moments load(const RingMoments& m) {
  return {load<Double4>(m.first), load<Double4>(m.second), load<Double2>(m.second + 4)};
}

SEGSERVE_INLINE void add(const Moments& m, Moments& total) {
  total.sum = total.sum + m.sum;
  total.square = total.square + m.square;
  total.square2 += m.square2;
}

/// Moments relative to another origin, from which t points to the present one. The fourth lane of t is 0.
SEGSERVE_INLINE Moments moved(const Moments& m, Double4 t) {
  const Double4 count = shuffle<3, 3, 3, 3>(m.sum);
  const Double2 count2 = pick<3, 3>(m.sum);
  const Double4 t1 = first(t), t2 = second(t), s1 = first(m.sum), s2 = second(m.sum);
  const Double2 u1 = first2(t), u2 = second2(t), v1 = first2(m.sum), v2 = second2(m.sum);
  return {m.sum + count * t, (m.square + count * (t1 * t2)) + (t1 * s2 + t2 * s1),
          (m.square2 + count2 * (u1 * u2)) + (u1 * v2 + u2 * v1)};
}

void ring_moments(std::size_t begin, std::size_t end, const NeighborRows& rows, const PaddedVec3* centroid,
                  RingMoments* rings) {
  for (std::size_t v = begin; v < end; ++v) {
    const Double4 origin = load<Double4>(centroid + v);
    Moments m{};
    for (std::uint32_t i = rows.offset[v]; i < rows.offset[v + 1]; ++i) {
      const Double4 d = load<Double4>(centroid + rows.neighbor[i]) - origin;
      add({d, first(d) * second(d), first2(d) * second2(d)}, m);
    }
    store(m.sum, rings[v].first);
    rings[v].first[3] = 1.0 + static_cast<double>(rows.offset[v + 1] - rows.offset[v]);
    store(m.square, rings[v].second);
    store(m.square2, rings[v].second + 4);
  }
}

/// The scatter matrices of up to 64 voxels, entry by entry, so that several matrices fill the lanes.
struct ScatterBlock {
  static constexpr std::size_t kMost = 64;
  alignas(kVectorBytes) double xx[kMost], xy[kMost], xz[kMost], yy[kMost], yz[kMost], zz[kMost];
  alignas(kVectorBytes) double x[kMost], y[kMost], z[kMost];  // the normals

  /// Sets matrix i from moments about any origin and the number of points.
  SEGSERVE_INLINE void set(std::size_t i, const Moments& m, double count) {
    const double scale = -1 / count;
    const Double4 square = m.square + scale * (first(m.sum) * second(m.sum));
    const Double2 square2 = m.square2 + scale * (first2(m.sum) * second2(m.sum));
    const Double2 head = pick<0, 1>(square), tail = pick<2, 3>(square);
    xx[i] = head[0], xy[i] = head[1], xz[i] = tail[0], yy[i] = tail[1];
    yz[i] = square2[0], zz[i] = square2[1];
  }

  SEGSERVE_INLINE NormalizedMatrix matrices(std::size_t i) const {
    return normalized({load<Doubles>(xx + i), load<Doubles>(xy + i), load<Doubles>(xz + i), load<Doubles>(yy + i),
                       load<Doubles>(yz + i), load<Doubles>(zz + i)});
  }

  SEGSERVE_INLINE void set_normals(std::size_t i, const Direction& normal) {
    store(normal.x, x + i);
    store(normal.y, y + i);
    store(normal.z, z + i);
  }

  void find_normals(std::size_t count) {
    for (std::size_t i = count; i % (2 * kDoubleLanes) != 0; ++i) xx[i] = xy[i] = xz[i] = yy[i] = yz[i] = zz[i] = 0;
    for (std::size_t i = 0; i < count; i += 2 * kDoubleLanes) {
      const NormalizedMatrix a = matrices(i), b = matrices(i + kDoubleLanes);
      Cubic of_a(a.matrix, a.trace > 0.0), of_b(b.matrix, b.trace > 0.0);
      find_roots(of_a, of_b);
      set_normals(i, eigenvector(a, of_a.t));
      set_normals(i + kDoubleLanes, eigenvector(b, of_b.t));
    }
  }
};

void fit_planes(std::size_t begin, std::size_t end, const NeighborRows& rows, const PaddedVec3* centroid,
                const RingMoments* rings, Vec3* normals) {
  ScatterBlock block;
  for (std::size_t base = begin; base < end; base += ScatterBlock::kMost) {
    const std::size_t count = end - base < ScatterBlock::kMost ? end - base : ScatterBlock::kMost;
    for (std::size_t v = base; v < base + count; ++v) {
      const Double4 origin = load<Double4>(centroid + v);
      const Moments own = load(rings[v]);
      Moments total = own;
      add(own, total);
      for (std::uint32_t i = rows.offset[v]; i < rows.offset[v + 1]; ++i) {
        const std::uint32_t u = rows.neighbor[i];
        add(moved(load(rings[u]), load<Double4>(centroid + u) - origin), total);
      }
      block.set(v - base, total, pick<3, 3>(total.sum)[0] + 1);  // the voxel itself, at the origin
    }
    block.find_normals(count);
    for (std::size_t i = 0; i < count; ++i) {
      Vec3& normal = normals[base + i];
      normal.x = block.x[i], normal.y = block.y[i], normal.z = block.z[i];
    }
  }
}

}  // namespace
}  // namespace segserve::SEGSERVE_SIMD_TARGET
