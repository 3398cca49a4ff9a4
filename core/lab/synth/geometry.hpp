// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "core/math/elementary.hpp"
#include "core/math/vec3.hpp"

namespace segserve::synth {

using math::kPi;

/// Linear interpolation: a for share = 0, b for share = 1.
inline Vec3 lerp(const Vec3& a, const Vec3& b, double share) { return a + share * (b - a); }

/// The pose of a right-handed frame: its axes and its origin in the coordinates of its parent frame.
struct Pose {
  Vec3 x{1, 0, 0}, y{0, 1, 0}, z{0, 0, 1}, origin;

  Vec3 rotate_to_parent(const Vec3& d) const { return d.x * x + d.y * y + d.z * z; }
  Vec3 rotate_to_local(const Vec3& d) const { return {dot(x, d), dot(y, d), dot(z, d)}; }
  Vec3 to_parent(const Vec3& p) const { return rotate_to_parent(p) + origin; }
  Vec3 to_local(const Vec3& p) const { return rotate_to_local(p - origin); }
  /// The pose of a child of this frame, in the coordinates of the parent of this frame.
  Pose operator*(const Pose& child) const {
    return {rotate_to_parent(child.x), rotate_to_parent(child.y), rotate_to_parent(child.z), to_parent(child.origin)};
  }
};

/// Axes as those of the parent.
inline Pose translated(const Vec3& origin) { return {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}, origin}; }

/// Rotated about z by `turns` full turns.
inline Pose rotated(double turns, const Vec3& origin) {
  const double s = math::sin(2 * kPi * turns);
  const double c = math::cos(2 * kPi * turns);
  return {{c, s, 0}, {-s, c, 0}, {0, 0, 1}, origin};
}

/// The z axis is along `direction`; the other two axes are arbitrary.
inline Pose with_z_along(const Vec3& direction, const Vec3& origin) {
  const Vec3 z = unit(direction);
  const Vec3 helper = z.x * z.x < 0.36 ? Vec3{1, 0, 0} : Vec3{0, 1, 0};
  const Vec3 x = unit(cross(helper, z));
  return {x, cross(z, x), z, origin};
}

}  // namespace segserve::synth
