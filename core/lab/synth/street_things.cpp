// SPDX-License-Identifier: Apache-2.0
#include "core/lab/synth/street_things.hpp"

namespace segserve::synth {
namespace {

const Texture kPaint{};  // A LiDAR sees no colors.

Solid upright(double bottom, double top, double height, const Vec3& foot) {
  return {{ShapeKind::kFrustum, bottom, top, height, 0}, translated(foot), kPaint};
}
Solid ellipsoid(double a, double b, double c, const Vec3& center) {
  return {{ShapeKind::kEllipsoid, a, b, c, 0}, translated(center), kPaint};
}
/// A cylinder that lies across, from y = -half to y = half.
Solid across(double radius, double half, double x, double y, double z) {
  return {{ShapeKind::kFrustum, radius, radius, 2 * half, 0}, with_z_along({0, 1, 0}, {x, y - half, z}), kPaint};
}

void add_wheels(double x, double y, std::vector<Solid>& parts) {
  constexpr double kRadius = 0.32, kHalfWidth = 0.1;
  for (const double end : {-x, x}) {
    for (const double side : {-y + kHalfWidth, y - kHalfWidth}) {
      parts.push_back(across(kRadius, kHalfWidth, end, side, kRadius));
    }
  }
}

}  // namespace

HouseholdObject random_car(Random& random) {
  const double x = random.uniform(1.9, 2.4), y = random.uniform(0.82, 0.92), roof = random.uniform(1.4, 1.55);
  constexpr double kFloor = 0.25, kWaist = 0.85, kNose = (kWaist - kFloor) / 2;
  HouseholdObject car{{}, x, y, roof, 0, 0};
  car.parts = {box_between({-x + kNose, -y, kFloor}, {x - kNose, y, kWaist}, kPaint),
               across(kNose, y, x - kNose, 0, kFloor + kNose), across(kNose, y, -x + kNose, 0, kFloor + kNose),
               ellipsoid(0.62 * x, 0.92 * y, roof - kWaist, {-0.1 * x, 0, kWaist})};
  add_wheels(0.62 * x, y, car.parts);
  return car;
}

HouseholdObject random_van(Random& random) {
  const double x = random.uniform(2.4, 3.0), y = random.uniform(0.95, 1.05), roof = random.uniform(1.95, 2.6);
  constexpr double kFloor = 0.3, kNose = 0.5;
  HouseholdObject van{{}, x, y, roof, 0, 0};
  van.parts = {box_between({-x, -y, kFloor}, {x - kNose, y, roof}, kPaint),
               box_between({x - kNose, -y, kFloor}, {x, y, 0.9}, kPaint), across(kNose, y, x - kNose, 0, 0.9)};
  add_wheels(0.62 * x, y, van.parts);
  return van;
}

HouseholdObject random_pedestrian(Random& random) {
  const double height = random.uniform(1.5, 1.95), s = height / 1.75, wide = s * random.uniform(0.9, 1.15);
  const double step = s * random.uniform(0, 0.2);
  HouseholdObject person{{}, 0.32 * s, 0.3 * s, height, 0, 0};
  person.parts = {upright(0.07 * s, 0.1 * s, 0.85 * s, {step, 0.1 * wide, 0}),
                  upright(0.07 * s, 0.1 * s, 0.85 * s, {-step, -0.1 * wide, 0}),
                  ellipsoid(0.16 * wide, 0.24 * wide, 0.4 * s, {0, 0, 1.12 * s}),
                  upright(0.05 * s, 0.05 * s, 0.12 * s, {0, 0, 1.46 * s}),
                  ellipsoid(0.11 * s, 0.09 * s, 0.13 * s, {0, 0, height - 0.13 * s})};
  return person;
}

HouseholdObject random_lamp_post(Random& random) {
  const double radius = random.uniform(0.06, 0.11), height = random.uniform(5, 8), arm = random.uniform(0.8, 1.6);
  HouseholdObject post{{}, radius, radius, height, 0, 0};
  post.parts = {upright(radius, 0.7 * radius, height, {}),
                box_between({0, -0.05, height - 0.15}, {arm, 0.05, height - 0.05}, kPaint)};
  if (random.chance(0.4)) {
    post.parts.push_back(box_between({radius, -0.35, 2.2}, {radius + 0.02, 0.35, 2.9}, kPaint));  // a sign
  }
  return post;
}

Tree random_tree(Random& random) {
  const double radius = random.uniform(0.1, 0.22), trunk = random.uniform(2.2, 3.2);
  Tree tree{{{}, radius, radius, trunk, 0, 0}, 0};
  tree.body.parts = {upright(1.2 * radius, 0.8 * radius, trunk + 0.6, {})};
  const std::uint32_t blobs = 3 + random.below(3);
  for (std::uint32_t i = 0; i < blobs; ++i) {
    const double a = random.uniform(0.8, 1.4), c = random.uniform(0.7, 1.2);
    const double x = random.uniform(-0.8, 0.8), y = random.uniform(-0.8, 0.8), z = trunk + 0.8 * c;
    tree.body.parts.push_back(ellipsoid(a, a, c, {x, y, z + random.uniform(0, 1.2)}));
  }
  tree.crown = blobs;
  tree.body.half_x = tree.body.half_y = 1.2 * radius;
  return tree;
}

}  // namespace segserve::synth
