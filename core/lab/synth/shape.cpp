// SPDX-License-Identifier: Apache-2.0
#include "core/lab/synth/shape.hpp"

#include <algorithm>
#include <cmath>

namespace segserve::synth {
namespace {

/// The patches of round shapes. A box has the patches 0 to 5 for -x, +x, -y, +y, -z, +z.
enum Face { kOuter = 0, kBottom = 1, kTop = 2, kInner = 3, kInnerFloor = 4 };

struct Ray {
  const Vec3& origin;
  const Vec3& direction;
  double t_min;

  double z(double t) const { return origin.z + t * direction.z; }
};

/// Takes a crossing that is nearer than the best one so far.
bool accept(double t, int face, double t_min, Crossing& hit) {
  if (!(t > t_min && t < hit.t)) return false;
  hit = {t, face};
  return true;
}

bool intersect_box(const Shape& s, const Ray& ray, Crossing& hit) {
  const double o[3] = {ray.origin.x, ray.origin.y, ray.origin.z};
  const double d[3] = {ray.direction.x, ray.direction.y, ray.direction.z};
  const double half[3] = {s.a, s.b, s.c};
  double enter = -1e30;
  double leave = 1e30;
  int enter_face = 0;
  int leave_face = 0;
  for (int i = 0; i < 3; ++i) {
    if (d[i] == 0) {
      if (std::abs(o[i]) > half[i]) return false;
      continue;
    }
    const double inverse = 1 / d[i];
    const double low = (-half[i] - o[i]) * inverse;
    const double high = (half[i] - o[i]) * inverse;
    const int up = inverse > 0 ? 1 : 0;
    if (std::min(low, high) > enter) {
      enter = std::min(low, high);
      enter_face = 2 * i + 1 - up;
    }
    if (std::max(low, high) < leave) {
      leave = std::max(low, high);
      leave_face = 2 * i + up;
    }
  }
  if (enter > leave) return false;
  return enter > ray.t_min ? accept(enter, enter_face, ray.t_min, hit) : accept(leave, leave_face, ray.t_min, hit);
}

/// The wall x^2 + y^2 = (r + k z)^2 between the heights z0 and z1.
bool intersect_wall(double r, double k, double z0, double z1, int face, const Ray& ray, Crossing& hit) {
  const Vec3& o = ray.origin;
  const Vec3& d = ray.direction;
  const double radius = r + k * o.z;
  const double a = d.x * d.x + d.y * d.y - k * k * d.z * d.z;
  const double b = o.x * d.x + o.y * d.y - k * d.z * radius;
  const double c = o.x * o.x + o.y * o.y - radius * radius;
  const double discriminant = b * b - a * c;
  if (discriminant < 0 || a == 0) return false;
  const double root = std::sqrt(discriminant);
  bool found = false;
  for (const double t : {(-b - root) / a, (-b + root) / a}) {
    const double z = ray.z(t);
    if (z >= z0 && z <= z1 && r + k * z >= 0 && accept(t, face, ray.t_min, hit)) found = true;
  }
  return found;
}

/// The ring at height z with inner <= distance from the axis <= outer.
bool intersect_ring(double z, double inner, double outer, int face, const Ray& ray, Crossing& hit) {
  if (ray.direction.z == 0) return false;
  const double t = (z - ray.origin.z) / ray.direction.z;
  const double x = ray.origin.x + t * ray.direction.x;
  const double y = ray.origin.y + t * ray.direction.y;
  const double square = x * x + y * y;
  return square <= outer * outer && square >= inner * inner && accept(t, face, ray.t_min, hit);
}

/// The part of a sphere around (0, 0, center) that lies below a height.
bool intersect_cap(double center, double radius, double z_max, int face, const Ray& ray, Crossing& hit) {
  const Vec3 o{ray.origin.x, ray.origin.y, ray.origin.z - center};
  const double a = dot(ray.direction, ray.direction);
  const double b = dot(o, ray.direction);
  const double discriminant = b * b - a * (dot(o, o) - radius * radius);
  if (discriminant < 0) return false;
  const double root = std::sqrt(discriminant);
  bool found = false;
  for (const double t : {(-b - root) / a, (-b + root) / a}) {
    if (ray.z(t) <= z_max && accept(t, face, ray.t_min, hit)) found = true;
  }
  return found;
}

bool intersect_ellipsoid(const Shape& s, const Ray& ray, Crossing& hit) {
  const Vec3 o{ray.origin.x / s.a, ray.origin.y / s.b, ray.origin.z / s.c};
  const Vec3 d{ray.direction.x / s.a, ray.direction.y / s.b, ray.direction.z / s.c};
  return intersect_cap(0, 1, 2, kOuter, {o, d, ray.t_min}, hit);
}

/// Frustum, cup and tube have the same outer wall, and differ in the surfaces that close it.
bool intersect_round(const Shape& s, const Ray& ray, Crossing& hit) {
  const double k = (s.b - s.a) / s.c;
  bool found = intersect_wall(s.a, k, 0, s.c, kOuter, ray, hit);
  const bool hollow = s.kind != ShapeKind::kFrustum;
  const double lower_hole = s.kind == ShapeKind::kTube ? s.a - s.d : 0;
  found |= intersect_ring(0, lower_hole, s.a, kBottom, ray, hit);
  found |= intersect_ring(s.c, hollow ? s.b - s.d : 0, s.b, kTop, ray, hit);
  if (!hollow) return found;
  const double floor = s.kind == ShapeKind::kCup ? s.d : 0;
  found |= intersect_wall(s.a - s.d, k, floor, s.c, kInner, ray, hit);
  if (floor > 0) found |= intersect_ring(floor, 0, s.a - s.d + k * floor, kInnerFloor, ray, hit);
  return found;
}

double cap_radius(double radius, double above_center) {
  return std::sqrt(std::max(0.0, radius * radius - above_center * above_center));
}

bool intersect_bowl(const Shape& s, const Ray& ray, Crossing& hit) {
  bool found = intersect_cap(s.a, s.a, s.b, kOuter, ray, hit);
  found |= intersect_cap(s.a, s.a - s.d, s.b, kInner, ray, hit);
  found |= intersect_ring(s.b, cap_radius(s.a - s.d, s.b - s.a), cap_radius(s.a, s.b - s.a), kTop, ray, hit);
  return found;
}

Surface box_surface(const Shape& s, const Vec3& p, int face) {
  const double sign = face % 2 == 1 ? 1 : -1;
  if (face < 2) return {{sign, 0, 0}, p.y + s.b, p.z + s.c, 2 * s.b, 2 * s.c, face};
  if (face < 4) return {{0, sign, 0}, p.x + s.a, p.z + s.c, 2 * s.a, 2 * s.c, face};
  return {{0, 0, sign}, p.x + s.a, p.y + s.b, 2 * s.a, 2 * s.b, face};
}

Surface flat_surface(const Vec3& p, double radius, double up, int face) {
  return {{0, 0, up}, p.x + radius, p.y + radius, 2 * radius, 2 * radius, face};
}

Surface wrapped_surface(const Vec3& normal, const Vec3& p, double radius, double height, int face) {
  const double around = 2 * kPi * radius;
  return {unit(normal), (math::atan2(p.y, p.x) + kPi) * radius, p.z, around, height, face};
}

Surface round_surface(const Shape& s, const Vec3& p, int face) {
  const double k = (s.b - s.a) / s.c;
  switch (face) {
    case kBottom:
      return flat_surface(p, s.a, -1, face);
    case kTop:
    case kInnerFloor:
      return flat_surface(p, s.b, 1, face);
    default:
      break;
  }
  const double radius = std::sqrt(p.x * p.x + p.y * p.y);
  const Vec3 outwards{p.x, p.y, -k * radius};
  return wrapped_surface(face == kInner ? -outwards : outwards, p, std::max(s.a, s.b), s.c, face);
}

}  // namespace

bool intersect(const Shape& shape, const Vec3& origin, const Vec3& direction, double t_min, Crossing& hit) {
  const Ray ray{origin, direction, t_min};
  switch (shape.kind) {
    case ShapeKind::kBox:
      return intersect_box(shape, ray, hit);
    case ShapeKind::kEllipsoid:
      return intersect_ellipsoid(shape, ray, hit);
    case ShapeKind::kBowl:
      return intersect_bowl(shape, ray, hit);
    case ShapeKind::kFrustum:
    case ShapeKind::kCup:
    case ShapeKind::kTube:
      return intersect_round(shape, ray, hit);
  }
  return false;
}

Surface surface_at(const Shape& shape, const Vec3& point, int face) {
  switch (shape.kind) {
    case ShapeKind::kBox:
      return box_surface(shape, point, face);
    case ShapeKind::kEllipsoid: {
      const Vec3 normal{point.x / (shape.a * shape.a), point.y / (shape.b * shape.b), point.z / (shape.c * shape.c)};
      return wrapped_surface(normal, point + Vec3{0, 0, shape.c}, shape.a, 2 * shape.c, face);
    }
    case ShapeKind::kBowl: {
      if (face == kTop) return flat_surface(point, shape.a, 1, face);
      const Vec3 outwards = point - Vec3{0, 0, shape.a};
      return wrapped_surface(face == kInner ? -outwards : outwards, point, shape.a, shape.b, face);
    }
    case ShapeKind::kFrustum:
    case ShapeKind::kCup:
    case ShapeKind::kTube:
      return round_surface(shape, point, face);
  }
  return {};
}

Sphere bounding_sphere(const Shape& shape) {
  switch (shape.kind) {
    case ShapeKind::kBox:
      return {{}, norm({shape.a, shape.b, shape.c})};
    case ShapeKind::kEllipsoid:
      return {{}, std::max({shape.a, shape.b, shape.c})};
    case ShapeKind::kBowl:
      return {{0, 0, shape.a}, shape.a};
    case ShapeKind::kFrustum:
    case ShapeKind::kCup:
    case ShapeKind::kTube: {
      const double widest = std::max(shape.a, shape.b);
      return {{0, 0, shape.c / 2}, std::sqrt(widest * widest + shape.c * shape.c / 4)};
    }
  }
  return {};
}

}  // namespace segserve::synth
