// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cmath>

namespace segserve {

/// A vector, or a point, of three coordinates. It serves in code that decides results, and in kernels, where Eigen
/// would not give the same bits for every CPU.
struct Vec3 {
  double x = 0, y = 0, z = 0;

  Vec3& operator+=(const Vec3& o) { return *this = {x + o.x, y + o.y, z + o.z}; }
  Vec3& operator-=(const Vec3& o) { return *this = {x - o.x, y - o.y, z - o.z}; }
  bool operator==(const Vec3&) const = default;
};

inline Vec3 operator+(Vec3 a, const Vec3& b) { return a += b; }
inline Vec3 operator-(Vec3 a, const Vec3& b) { return a -= b; }
inline Vec3 operator-(const Vec3& a) { return {-a.x, -a.y, -a.z}; }
inline Vec3 operator*(double s, const Vec3& a) { return {s * a.x, s * a.y, s * a.z}; }
inline double dot(const Vec3& a, const Vec3& b) { return a.x * b.x + a.y * b.y + a.z * b.z; }
inline Vec3 cross(const Vec3& a, const Vec3& b) {
  return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}
inline double norm(const Vec3& a) { return std::sqrt(dot(a, a)); }

/// a / |a|, or the zero vector, which stands for no direction, if a is zero.
inline Vec3 unit(const Vec3& a) {
  const double length = norm(a);
  return length > 0 ? (1 / length) * a : Vec3{};
}

}  // namespace segserve
