// SPDX-License-Identifier: Apache-2.0
#include "core/math/symmetric_matrix3.hpp"

#include <algorithm>

namespace segserve {
namespace {

/// The smallest root of the characteristic polynomial t^3 - t^2 + c1 t - c0 of a matrix of trace 1. Newton's method
/// starts at 0, left of all roots. Its steps rise towards the smallest one and never pass it.
double smallest_eigenvalue(const Symmetric3& a) {
  const double c1 = (a.xx * a.yy - a.xy * a.xy) + (a.xx * a.zz - a.xz * a.xz) + (a.yy * a.zz - a.yz * a.yz);
  const double c0 =
      a.xx * (a.yy * a.zz - a.yz * a.yz) - a.xy * (a.xy * a.zz - a.yz * a.xz) + a.xz * (a.xy * a.yz - a.yy * a.xz);
  double t = 0;
  for (int step = 0; step < 50; ++step) {
    const double value = ((t - 1) * t + c1) * t - c0;
    const double slope = (3 * t - 2) * t + c1;
    if (value >= 0 || slope <= 0) break;
    const double next = t - value / slope;
    if (next - t <= 1e-16 * next) break;
    t = next;
  }
  return t;
}

}  // namespace

Vec3 smallest_eigenvector(const Symmetric3& a) {
  const double trace = a.xx + a.yy + a.zz;
  if (!(trace > 0)) return {};
  const Symmetric3 n = (1 / trace) * a;
  const double t = smallest_eigenvalue(n);
  // The rows of n - t I span the plane orthogonal to the eigenvector. Of their products the longest is the most exact.
  const Vec3 rows[3] = {{n.xx - t, n.xy, n.xz}, {n.xy, n.yy - t, n.yz}, {n.xz, n.yz, n.zz - t}};
  const Vec3 products[3] = {cross(rows[0], rows[1]), cross(rows[0], rows[2]), cross(rows[1], rows[2])};
  const Vec3& best = *std::ranges::max_element(products, {}, [](const Vec3& p) { return dot(p, p); });
  // Its length is about (second - smallest)(largest - smallest) eigenvalue of the normalized matrix.
  constexpr double kUndefined = 1e-9;
  return dot(best, best) > kUndefined * kUndefined ? unit(best) : Vec3{};
}

}  // namespace segserve
