// SPDX-License-Identifier: Apache-2.0
#include "core/lab/synth/shape.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <string>

#include "core/math/random.hpp"

namespace segserve::synth {
namespace {

// Membership straight from the definitions in shape.hpp, independent of any ray.
bool inside(const Shape& s, const Vec3& p) {
  const double radius = std::sqrt(p.x * p.x + p.y * p.y);
  const double outer = s.a + (s.b - s.a) * p.z / s.c;
  switch (s.kind) {
    case ShapeKind::kBox:
      return std::abs(p.x) < s.a && std::abs(p.y) < s.b && std::abs(p.z) < s.c;
    case ShapeKind::kEllipsoid:
      return p.x * p.x / (s.a * s.a) + p.y * p.y / (s.b * s.b) + p.z * p.z / (s.c * s.c) < 1;
    case ShapeKind::kFrustum:
      return p.z > 0 && p.z < s.c && radius < outer;
    case ShapeKind::kCup:
      return p.z > 0 && p.z < s.c && radius < outer && (p.z < s.d || radius > outer - s.d);
    case ShapeKind::kTube:
      return p.z > 0 && p.z < s.c && radius < outer && radius > outer - s.d;
    case ShapeKind::kBowl: {
      const double r = norm(p - Vec3{0, 0, s.a});
      return p.z < s.b && r < s.a && r > s.a - s.d;
    }
  }
  return false;
}

struct Case {
  const char* name;
  Shape shape;
};

class ShapeTest : public testing::TestWithParam<Case> {};

// A ray from outside that meets the solid enters it there, was outside all the way, and the normal
// points back out; a ray that meets nothing has no sample inside.
TEST_P(ShapeTest, FirstCrossingAgreesWithMembership) {
  const Shape& shape = GetParam().shape;
  const Sphere around = bounding_sphere(shape);
  Random random(3);
  int hits = 0;
  for (int i = 0; i < 4000; ++i) {
    const auto point_around = [&](double scale) {
      const double x = random.gaussian(), y = random.gaussian(), z = random.gaussian();
      return around.center + scale * around.radius * unit({x, y, z});
    };
    const Vec3 origin = point_around(3);
    const Vec3 direction = point_around(random.uniform()) - origin;
    Crossing hit{2, 0};
    const bool met = intersect(shape, origin, direction, 1e-6, hit);
    const double end = met ? hit.t - 1e-5 : 2;
    for (int k = 0; k < 200; ++k) {
      ASSERT_FALSE(inside(shape, origin + (end * k / 200) * direction)) << GetParam().name << " ray " << i;
    }
    if (!met) continue;
    ++hits;
    const Vec3 point = origin + hit.t * direction;
    const Surface surface = surface_at(shape, point, hit.face);
    EXPECT_NEAR(norm(surface.normal), 1, 1e-9);
    EXPECT_LE(dot(surface.normal, direction), 1e-9);
    EXPECT_TRUE(inside(shape, point - 1e-6 * surface.normal)) << GetParam().name << " face " << hit.face;
    EXPECT_FALSE(inside(shape, point + 1e-6 * surface.normal)) << GetParam().name << " face " << hit.face;
    EXPECT_LE(norm(point - around.center), around.radius + 1e-9);
    EXPECT_GE(surface.u, -1e-9);
    EXPECT_LE(surface.u, surface.width + 1e-9);
  }
  EXPECT_GT(hits, 500);
}

INSTANTIATE_TEST_SUITE_P(All, ShapeTest,
                         testing::Values(Case{"box", {ShapeKind::kBox, 0.1, 0.05, 0.2, 0}},
                                         Case{"ellipsoid", {ShapeKind::kEllipsoid, 0.1, 0.07, 0.05, 0}},
                                         Case{"cylinder", {ShapeKind::kFrustum, 0.05, 0.05, 0.12, 0}},
                                         Case{"cone", {ShapeKind::kFrustum, 0.06, 0, 0.12, 0}},
                                         Case{"funnel", {ShapeKind::kFrustum, 0.03, 0.08, 0.1, 0}},
                                         Case{"cup", {ShapeKind::kCup, 0.03, 0.04, 0.1, 0.01}},
                                         Case{"tube", {ShapeKind::kTube, 0.05, 0.05, 0.04, 0.012}},
                                         Case{"bowl", {ShapeKind::kBowl, 0.1, 0.06, 0, 0.01}}),
                         [](const auto& tested) { return std::string(tested.param.name); });

}  // namespace
}  // namespace segserve::synth
