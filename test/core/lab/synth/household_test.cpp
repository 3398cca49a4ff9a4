// SPDX-License-Identifier: Apache-2.0
#include "core/lab/synth/household.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "core/lab/synth/furniture.hpp"
#include "core/lab/synth/street_things.hpp"

namespace segserve::synth {
namespace {

// Where rays from all around meet the parts; checks that every such point lies in the box that the
// object declares, which is what keeps objects from intersecting each other.
void expect_within_declared_box(const HouseholdObject& object, Random& random) {
  constexpr double kSlack = 1e-6;
  for (const Solid& part : object.parts) {
    const Sphere around = bounding_sphere(part.shape);
    for (int i = 0; i < 60; ++i) {
      const double x = random.gaussian(), y = random.gaussian(), z = random.gaussian();
      const Vec3 origin = around.center + (4 * around.radius) * unit({x, y, z});
      const double ax = random.uniform(-1, 1), ay = random.uniform(-1, 1), az = random.uniform(-1, 1);
      const Vec3 aim = around.center + (0.7 * around.radius) * Vec3{ax, ay, az};
      Crossing hit{1e9, 0};
      if (!intersect(part.shape, origin, aim - origin, 1e-9, hit)) continue;
      const Vec3 p = part.pose.to_parent(origin + hit.t * (aim - origin));
      ASSERT_LE(std::abs(p.x), object.half_x + kSlack);
      ASSERT_LE(std::abs(p.y), object.half_y + kSlack);
      ASSERT_GE(p.z, -kSlack);
      ASSERT_LE(p.z, object.height + kSlack);
    }
  }
}

TEST(HouseholdTest, ObjectsLieWithinTheBoxTheyDeclare) {
  Random random(5);
  for (int i = 0; i < 600; ++i) {
    SCOPED_TRACE(i);
    expect_within_declared_box(random_household_object(random), random);
    if (HasFatalFailure()) return;
  }
}

TEST(HouseholdTest, ObjectsHaveHouseholdSizes) {
  Random random(6);
  for (int i = 0; i < 600; ++i) {
    const HouseholdObject object = random_household_object(random);
    const double largest = std::max({2 * object.half_x, 2 * object.half_y, object.height});
    EXPECT_GE(largest, 0.04);
    EXPECT_LE(largest, 0.41);
    EXPECT_LE(object.top_x, object.half_x);
    EXPECT_LE(object.top_y, object.half_y);
  }
}

TEST(HouseholdTest, HollowObjectsLieWithinTheBoxTheyDeclare) {
  Random random(7);
  for (int i = 0; i < 400; ++i) {
    SCOPED_TRACE(i);
    const HouseholdObject object = random_hollow_object(random);
    expect_within_declared_box(object, random);
    if (HasFatalFailure()) return;
    EXPECT_GE(std::max(2 * object.half_x, 2 * object.half_y), 0.06);
    EXPECT_LE(std::max({2 * object.half_x, 2 * object.half_y, object.height}), 0.5);
  }
}

TEST(HouseholdTest, CompactObjectsLieWithinTheBoxTheyDeclare) {
  Random random(9);
  for (int i = 0; i < 400; ++i) {
    SCOPED_TRACE(i);
    const HouseholdObject object = random_compact_object(random);
    expect_within_declared_box(object, random);
    if (HasFatalFailure()) return;
    EXPECT_GE(std::max({2 * object.half_x, 2 * object.half_y, object.height}), 0.04);
  }
}

TEST(StreetThingsTest, ThingsLieWithinTheBoxTheyDeclare) {
  Random random(9);
  for (int i = 0; i < 100; ++i) {
    SCOPED_TRACE(i);
    for (const auto make : {random_car, random_van, random_pedestrian}) {
      expect_within_declared_box(make(random), random);
      if (HasFatalFailure()) return;
    }
  }
}

TEST(FurnitureTest, PiecesLieWithinTheBoxTheyDeclareAndShelvesAreOnThem) {
  Random random(8);
  for (int i = 0; i < 100; ++i) {
    for (const auto make : {random_table, random_chair, random_bookcase, random_sideboard, random_armchair, random_sofa,
                            random_bed, random_desk, random_office_chair, random_stool, random_floor_lamp}) {
      const Furniture piece = make(random);
      expect_within_declared_box(piece.body, random);
      if (HasFatalFailure()) return;
      for (const Shelf& shelf : piece.shelves) {
        EXPECT_LE(std::abs(shelf.pose.origin.x) + shelf.half_x, piece.body.half_x);
        EXPECT_LE(std::abs(shelf.pose.origin.y) + shelf.half_y, piece.body.half_y);
        EXPECT_LE(shelf.pose.origin.z, piece.body.height + 1e-9);
      }
    }
  }
}

}  // namespace
}  // namespace segserve::synth
