#pragma once

#include "core/math/elementary.hpp"
#include "core/math/vec3.hpp"

namespace segserve::synth {

using math::kPi;

/// Mixture of a and b, `share` of b.
inline Vec3 lerp(const Vec3& a, const Vec3& b, double share) { return a + share * (b - a); }

/// A right-handed frame: its axes and its origin in the coordinates of its parent.
struct Pose {
  Vec3 x{1, 0, 0}, y{0, 1, 0}, z{0, 0, 1}, origin;

  Vec3 direction_out(const Vec3& d) const { return d.x * x + d.y * y + d.z * z; }
  Vec3 direction_in(const Vec3& d) const { return {dot(x, d), dot(y, d), dot(z, d)}; }
  Vec3 point_out(const Vec3& p) const { return direction_out(p) + origin; }
  Vec3 point_in(const Vec3& p) const { return direction_in(p - origin); }
  /// The pose of a child of this frame, in the coordinates of this frame's parent.
  Pose operator*(const Pose& child) const {
    return {direction_out(child.x), direction_out(child.y), direction_out(child.z), point_out(child.origin)};
  }
};

inline Pose at(const Vec3& origin) { return {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}, origin}; }

/// Turned about z by `turns` of 360 degrees.
inline Pose turned(double turns, const Vec3& origin) {
  const double s = math::sin(2 * kPi * turns);
  const double c = math::cos(2 * kPi * turns);
  return {{c, s, 0}, {-s, c, 0}, {0, 0, 1}, origin};
}

/// Local z along `direction`, the other axes as they fall.
inline Pose along(const Vec3& direction, const Vec3& origin) {
  const Vec3 z = unit(direction);
  const Vec3 helper = z.x * z.x < 0.36 ? Vec3{1, 0, 0} : Vec3{0, 1, 0};
  const Vec3 x = unit(cross(helper, z));
  return {x, cross(z, x), z, origin};
}

}  // namespace segserve::synth
