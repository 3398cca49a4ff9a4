// SPDX-License-Identifier: Apache-2.0
// See core/simd/simd_vectors.hpp. Computes smallest_eigenvector (core/math/symmetric_matrix3.hpp) of as many matrices
// as a vector has lanes.
#pragma once

#include "core/simd/simd_vectors.hpp"

namespace segserve::SEGSERVE_SIMD_TARGET {
namespace {

struct Direction {
  Doubles x, y, z;
};

struct Matrix {
  Doubles xx, xy, xz, yy, yz, zz;
};

SEGSERVE_INLINE Direction cross_product(const Direction& a, const Direction& b) {
  return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}

SEGSERVE_INLINE Doubles dot_product(const Direction& a, const Direction& b) {
  return a.x * b.x + a.y * b.y + a.z * b.z;
}

/// The characteristic polynomial t^3 - t^2 + c1 t - c0 of matrices of trace 1, and a lower bound t of its smallest
/// root.
struct Cubic {
  Doubles c1, c0, t = {};
  Int64s moving;

  SEGSERVE_INLINE Cubic(const Matrix& a, Int64s defined)
      : c1((a.xx * a.yy - a.xy * a.xy) + (a.xx * a.zz - a.xz * a.xz) + (a.yy * a.zz - a.yz * a.yz)),
        c0(a.xx * (a.yy * a.zz - a.yz * a.yz) - a.xy * (a.xy * a.zz - a.yz * a.xz) +
           a.xz * (a.xy * a.yz - a.yy * a.xz)),
        moving(defined) {}

  /// Makes a step of Newton's method in the lanes that have not converged.
  SEGSERVE_INLINE void step() {
    const Doubles value = ((t - 1.0) * t + c1) * t - c0;
    const Doubles slope = (3.0 * t - 2.0) * t + c1;
    moving &= ~((value >= 0.0) | (slope <= 0.0));
    const Doubles next = t - value / slope;
    moving &= ~(next - t <= 1e-16 * next);
    t = moving ? next : t;
  }
};

/// Treats two vectors at once, because the steps of one fill the time that those of the other wait for divisions.
SEGSERVE_INLINE void find_roots(Cubic& a, Cubic& b) {
  for (int step = 0; step < 50 && any(a.moving | b.moving); ++step) {
    a.step();
    b.step();
  }
}

struct NormalizedMatrix {
  Matrix matrix;
  Doubles trace;
};
SEGSERVE_INLINE NormalizedMatrix normalized(const Matrix& a) {
  const Doubles trace = a.xx + a.yy + a.zz;
  const Doubles scale = 1.0 / trace;
  return {{scale * a.xx, scale * a.xy, scale * a.xz, scale * a.yy, scale * a.yz, scale * a.zz}, trace};
}

/// The eigenvector of the matrix for its smallest eigenvalue t.
SEGSERVE_INLINE Direction eigenvector(const NormalizedMatrix& normal, Doubles t) {
  const Matrix& n = normal.matrix;
  const Direction rows[3] = {{n.xx - t, n.xy, n.xz}, {n.xy, n.yy - t, n.yz}, {n.xz, n.yz, n.zz - t}};
  Direction best = cross_product(rows[0], rows[1]);
  Doubles best_square = dot_product(best, best);
  const auto compare = [&](const Direction& product) {
    const Doubles square = dot_product(product, product);
    const Int64s better = best_square < square;
    best.x = better ? product.x : best.x;
    best.y = better ? product.y : best.y;
    best.z = better ? product.z : best.z;
    best_square = better ? square : best_square;
  };
  compare(cross_product(rows[0], rows[2]));
  compare(cross_product(rows[1], rows[2]));
  constexpr double kUndefined = 1e-9;
  const Int64s defined = (normal.trace > 0.0) & (best_square > kUndefined * kUndefined);
  const Doubles inverse = 1.0 / square_root(best_square);
  const Doubles none = {};
  return {defined ? inverse * best.x : none, defined ? inverse * best.y : none, defined ? inverse * best.z : none};
}

}  // namespace
}  // namespace segserve::SEGSERVE_SIMD_TARGET
