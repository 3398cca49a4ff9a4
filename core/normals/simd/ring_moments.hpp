// Part of the kernels; see core/simd/simd_vectors.hpp. Moments of neighbourhoods, with x, y, z in lanes, and the planes
// through them: 4.0 -> 1.9 ms a frame.
#pragma once

#include "core/normals/simd/normal_kernels.hpp"
#include "core/normals/simd/smallest_eigenvector.hpp"
#include "core/simd/simd_vectors.hpp"

namespace segserve::SEGSERVE_KERNELS {
namespace {

// The six products of a symmetric matrix are those of the lanes first(v) and second(v), and of the lanes first2(v) and
// second2(v): xx, xy, xz, yy and yz, zz.
SEGSERVE_INLINE Real4 first(Real4 v) { return shuffle<0, 0, 0, 1>(v); }
SEGSERVE_INLINE Real4 second(Real4 v) { return shuffle<0, 1, 2, 1>(v); }
SEGSERVE_INLINE Real2 first2(Real4 v) { return pick<1, 2>(v); }
SEGSERVE_INLINE Real2 second2(Real4 v) { return pick<2, 2>(v); }

struct MomentLanes {
  Real4 sum;      // x, y, z, count
  Real4 square;   // xx, xy, xz, yy
  Real2 square2;  // yz, zz
};

SEGSERVE_INLINE MomentLanes load(const RingMoments& m) {
  return {load<Real4>(&m.x), load<Real4>(&m.xx), load<Real2>(&m.yz)};
}

SEGSERVE_INLINE void add(const MomentLanes& m, MomentLanes& total) {
  total.sum = total.sum + m.sum;
  total.square = total.square + m.square;
  total.square2 += m.square2;
}

/// Moments about a point, taken about another one instead; t: the way from that one to the old. Its w is 0.
SEGSERVE_INLINE MomentLanes moved(const MomentLanes& m, Real4 t) {
  const Real4 count = shuffle<3, 3, 3, 3>(m.sum);
  const Real2 count2 = pick<3, 3>(m.sum);
  const Real4 t1 = first(t), t2 = second(t), s1 = first(m.sum), s2 = second(m.sum);
  const Real2 u1 = first2(t), u2 = second2(t), v1 = first2(m.sum), v2 = second2(m.sum);
  return {m.sum + count * t, (m.square + count * (t1 * t2)) + (t1 * s2 + t2 * s1),
          (m.square2 + count2 * (u1 * u2)) + (u1 * v2 + u2 * v1)};
}

void ring_moments(std::size_t begin, std::size_t end, const NeighborRows& rows, const Quad* centroid,
                  RingMoments* rings) {
  for (std::size_t v = begin; v < end; ++v) {
    const Real4 origin = load<Real4>(&centroid[v].x);
    MomentLanes m{};
    for (std::uint32_t i = rows.offset[v]; i < rows.offset[v + 1]; ++i) {
      const Real4 d = load<Real4>(&centroid[rows.neighbor[i]].x) - origin;
      add({d, first(d) * second(d), first2(d) * second2(d)}, m);
    }
    store(m.sum, &rings[v].x);
    rings[v].count = 1.0 + static_cast<double>(rows.offset[v + 1] - rows.offset[v]);
    store(m.square, &rings[v].xx);
    store(m.square2, &rings[v].yz);
  }
}

/// Scatter matrices of up to 64 voxels, entry by entry, on their way into lanes.
struct ScatterBlock {
  static constexpr std::size_t kMost = 64;
  alignas(kLaneBytes) double xx[kMost], xy[kMost], xz[kMost], yy[kMost], yz[kMost], zz[kMost];
  alignas(kLaneBytes) double x[kMost], y[kMost], z[kMost];  // their normals

  /// Moments less those of as many points in the mean.
  SEGSERVE_INLINE void set(std::size_t i, const MomentLanes& m, double count) {
    const double scale = -1 / count;
    const Real4 square = m.square + scale * (first(m.sum) * second(m.sum));
    const Real2 square2 = m.square2 + scale * (first2(m.sum) * second2(m.sum));
    const Real2 head = pick<0, 1>(square), tail = pick<2, 3>(square);
    xx[i] = head[0], xy[i] = head[1], xz[i] = tail[0], yy[i] = tail[1];
    yz[i] = square2[0], zz[i] = square2[1];
  }

  SEGSERVE_INLINE Normalised matrices(std::size_t i) const {
    return normalised({load<Real>(xx + i), load<Real>(xy + i), load<Real>(xz + i), load<Real>(yy + i),
                       load<Real>(yz + i), load<Real>(zz + i)});
  }

  SEGSERVE_INLINE void set_normals(std::size_t i, const Direction& normal) {
    store(normal.x, x + i);
    store(normal.y, y + i);
    store(normal.z, z + i);
  }

  void find_normals(std::size_t count) {
    for (std::size_t i = count; i % (2 * kReals) != 0; ++i) xx[i] = xy[i] = xz[i] = yy[i] = yz[i] = zz[i] = 0;
    for (std::size_t i = 0; i < count; i += 2 * kReals) {
      const Normalised a = matrices(i), b = matrices(i + kReals);
      Cubic of_a(a.matrix, a.trace > 0.0), of_b(b.matrix, b.trace > 0.0);
      find_roots(of_a, of_b);
      set_normals(i, eigenvector(a, of_a.t));
      set_normals(i + kReals, eigenvector(b, of_b.t));
    }
  }
};

void fit_planes(std::size_t begin, std::size_t end, const NeighborRows& rows, const Quad* centroid,
                const RingMoments* rings, Vec3* normals) {
  ScatterBlock block;
  for (std::size_t base = begin; base < end; base += ScatterBlock::kMost) {
    const std::size_t count = end - base < ScatterBlock::kMost ? end - base : ScatterBlock::kMost;
    for (std::size_t v = base; v < base + count; ++v) {
      const Real4 origin = load<Real4>(&centroid[v].x);
      const MomentLanes own = load(rings[v]);
      MomentLanes total = own;
      add(own, total);
      for (std::uint32_t i = rows.offset[v]; i < rows.offset[v + 1]; ++i) {
        const std::uint32_t u = rows.neighbor[i];
        add(moved(load(rings[u]), load<Real4>(&centroid[u].x) - origin), total);
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
}  // namespace segserve::SEGSERVE_KERNELS
