// Part of the kernels; see math/lanes.hpp. smallest_eigenvector of math/symmetric3, for as many matrices as a vector
// has lanes.
#pragma once

#include "segserve/math/lanes.hpp"

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

/// Newton's steps of each lane that is `moving`, until the last one has arrived.
SEGSERVE_INLINE Real smallest_eigenvalue(const Matrix& a, RealMask moving) {
  const Real c1 = (a.xx * a.yy - a.xy * a.xy) + (a.xx * a.zz - a.xz * a.xz) + (a.yy * a.zz - a.yz * a.yz);
  const Real c0 =
      a.xx * (a.yy * a.zz - a.yz * a.yz) - a.xy * (a.xy * a.zz - a.yz * a.xz) + a.xz * (a.xy * a.yz - a.yy * a.xz);
  Real t = {};
  for (int step = 0; step < 50 && any(moving); ++step) {
    const Real value = ((t - 1.0) * t + c1) * t - c0;
    const Real slope = (3.0 * t - 2.0) * t + c1;
    moving &= ~((value >= 0.0) | (slope <= 0.0));
    const Real next = t - value / slope;
    moving &= ~(next - t <= 1e-16 * next);
    t = moving ? next : t;
  }
  return t;
}

SEGSERVE_INLINE Direction smallest_eigenvector(const Matrix& a) {
  const Real trace = a.xx + a.yy + a.zz;
  const Real scale = 1.0 / trace;
  const Matrix n{scale * a.xx, scale * a.xy, scale * a.xz, scale * a.yy, scale * a.yz, scale * a.zz};
  const Real t = smallest_eigenvalue(n, trace > 0.0);
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
  const RealMask defined = (trace > 0.0) & (best_square > kUndefined * kUndefined);
  const Real inverse = 1.0 / square_root(best_square);
  const Real none = {};
  return {defined ? inverse * best.x : none, defined ? inverse * best.y : none, defined ? inverse * best.z : none};
}

}  // namespace
}  // namespace segserve::SEGSERVE_KERNELS
