// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "core/math/eigen_conversion.hpp"
#include "core/math/vec3.hpp"
#include "segserve/tracking.hpp"

namespace segserve::tracking {

/// The motion p -> R p + origin, where x, y and z are the columns of R. It computes in one order on every CPU.
struct RigidMotion {
  Vec3 x{1, 0, 0}, y{0, 1, 0}, z{0, 0, 1}, origin;

  Vec3 rotate(const Vec3& d) const { return d.x * x + d.y * y + d.z * z; }
  Vec3 operator()(const Vec3& p) const { return rotate(p) + origin; }
  Vec3 rotate_back(const Vec3& d) const { return {dot(x, d), dot(y, d), dot(z, d)}; }

  RigidMotion inverse() const { return {{x.x, y.x, z.x}, {x.y, y.y, z.y}, {x.z, y.z, z.z}, -rotate_back(origin)}; }
  /// First `first`, then this.
  RigidMotion after(const RigidMotion& first) const {
    return {rotate(first.x), rotate(first.y), rotate(first.z), (*this)(first.origin)};
  }
};

inline RigidMotion to_motion(const RigidTransform& t) {
  return {to_vec3(t.rotation.col(0)), to_vec3(t.rotation.col(1)), to_vec3(t.rotation.col(2)), to_vec3(t.translation)};
}

inline RigidTransform to_transform(const RigidMotion& m) {
  RigidTransform t;
  t.rotation << to_eigen(m.x), to_eigen(m.y), to_eigen(m.z);
  t.translation = to_eigen(m.origin);
  return t;
}

}  // namespace segserve::tracking
