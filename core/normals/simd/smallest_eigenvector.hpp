// Part of the kernels; see core/simd/simd_vectors.hpp. smallest_eigenvector of math/symmetric3, for as many matrices as
// a vector has lanes.
#pragma once

#include "core/simd/simd_vectors.hpp"

namespace segserve::SEGSERVE_KERNELS {
namespace {

struct Direction {
  Real x, y, z;
};

struct Matrix {
  Real xx, xy, xz, yy, yz, zz;
};

SEGSERVE_INLINE Direction cross_product(const Direction& a, const Direction& b) {
  return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}

SEGSERVE_INLINE Real dot_product(const Direction& a, const Direction& b) { return a.x * b.x + a.y * b.y + a.z * b.z; }

/// The characteristic polynomial t^3 - t^2 + c1 t - c0 of matrices of trace 1, and where its smallest root is known to
/// be not below.
struct Cubic {
  Real c1, c0, t = {};
  RealMask moving;

  SEGSERVE_INLINE Cubic(const Matrix& a, RealMask defined)
      : c1((a.xx * a.yy - a.xy * a.xy) + (a.xx * a.zz - a.xz * a.xz) + (a.yy * a.zz - a.yz * a.yz)),
        c0(a.xx * (a.yy * a.zz - a.yz * a.yz) - a.xy * (a.xy * a.zz - a.yz * a.xz) +
           a.xz * (a.xy * a.yz - a.yy * a.xz)),
        moving(defined) {}

  /// A step of Newton's, in the lanes that have not arrived.
  SEGSERVE_INLINE void step() {
    const Real value = ((t - 1.0) * t + c1) * t - c0;
    const Real slope = (3.0 * t - 2.0) * t + c1;
    moving &= ~((value >= 0.0) | (slope <= 0.0));
    const Real next = t - value / slope;
    moving &= ~(next - t <= 1e-16 * next);
    t = moving ? next : t;
  }
};

/// Two vectors at once: the steps of one fill the time that those of the other wait for their divisions.
SEGSERVE_INLINE void find_roots(Cubic& a, Cubic& b) {
  for (int step = 0; step < 50 && any(a.moving | b.moving); ++step) {
    a.step();
    b.step();
  }
}

struct Normalised {
  Matrix matrix;
  Real trace;
};
SEGSERVE_INLINE Normalised normalised(const Matrix& a) {
  const Real trace = a.xx + a.yy + a.zz;
  const Real scale = 1.0 / trace;
  return {{scale * a.xx, scale * a.xy, scale * a.xz, scale * a.yy, scale * a.yz, scale * a.zz}, trace};
}

/// The eigenvector of n.matrix to its smallest eigenvalue t.
SEGSERVE_INLINE Direction eigenvector(const Normalised& normal, Real t) {
  const Matrix& n = normal.matrix;
  const Direction rows[3] = {{n.xx - t, n.xy, n.xz}, {n.xy, n.yy - t, n.yz}, {n.xz, n.yz, n.zz - t}};
  Direction best = cross_product(rows[0], rows[1]);
  Real best_square = dot_product(best, best);
  const auto compare = [&](const Direction& product) {
    const Real square = dot_product(product, product);
    const RealMask better = best_square < square;
    best.x = better ? product.x : best.x;
    best.y = better ? product.y : best.y;
    best.z = better ? product.z : best.z;
    best_square = better ? square : best_square;
  };
  compare(cross_product(rows[0], rows[2]));
  compare(cross_product(rows[1], rows[2]));
  constexpr double kUndefined = 1e-9;
  const RealMask defined = (normal.trace > 0.0) & (best_square > kUndefined * kUndefined);
  const Real inverse = 1.0 / square_root(best_square);
  const Real none = {};
  return {defined ? inverse * best.x : none, defined ? inverse * best.y : none, defined ? inverse * best.z : none};
}

}  // namespace
}  // namespace segserve::SEGSERVE_KERNELS
