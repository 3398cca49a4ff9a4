// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "core/math/vec3.hpp"

namespace segserve {

/// A symmetric 3x3 matrix, such as the covariance or the scatter of points.
struct Symmetric3 {
  double xx = 0, xy = 0, xz = 0, yy = 0, yz = 0, zz = 0;

  Symmetric3& operator+=(const Symmetric3& o) {
    xx += o.xx, xy += o.xy, xz += o.xz, yy += o.yy, yz += o.yz, zz += o.zz;
    return *this;
  }
};

inline Symmetric3 operator*(double s, const Symmetric3& a) {
  return {s * a.xx, s * a.xy, s * a.xz, s * a.yy, s * a.yz, s * a.zz};
}

/// v v^T
inline Symmetric3 outer(const Vec3& v) { return {v.x * v.x, v.x * v.y, v.x * v.z, v.y * v.y, v.y * v.z, v.z * v.z}; }

/// The unit eigenvector, of either sign, of the smallest eigenvalue of a positive semidefinite matrix. For a scatter
/// matrix it is the normal of the plane that fits best. It is the zero vector if its direction is not defined, because
/// the two smallest eigenvalues are equal (points on a line, or a single point).
Vec3 smallest_eigenvector(const Symmetric3& a);

}  // namespace segserve
