// SPDX-License-Identifier: Apache-2.0
#include "core/lab/synth/arrangement.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <set>

namespace segserve::synth {
namespace {

using Footprint = Arrangement::Footprint;

bool contains(const Footprint& f, const Vec3& p) {
  const Vec3 local = rotated(f.turns, {f.x, f.y, 0}).to_local(p);
  return std::abs(local.x) < f.half_x && std::abs(local.y) < f.half_y && p.z > f.bottom && p.z < f.top;
}

TEST(ArrangementTest, KeepsTheGap) {
  Arrangement arrangement;
  arrangement.occupy({0, 0, 0, 0.1, 0.1, 0, 0.2});
  EXPECT_FALSE(arrangement.is_free({0.25, 0, 0, 0.1, 0.1, 0, 0.1}, 0.06));
  EXPECT_TRUE(arrangement.is_free({0.25, 0, 0, 0.1, 0.1, 0, 0.1}, 0.04));
}

TEST(ArrangementTest, TurnedBoxesAreJudgedByTheirOwnEdges) {
  Arrangement arrangement;
  arrangement.occupy({0, 0, 0, 0.1, 0.1, 0, 0.2});
  // A long thin box across the corner: its upright bounding rectangle overlaps, itself it does not.
  EXPECT_TRUE(arrangement.is_free({0.16, 0.16, 0.125 + 0.25, 0.3, 0.01, 0, 0.2}, 0));
  EXPECT_FALSE(arrangement.is_free({0.09, 0.09, 0.125 + 0.25, 0.3, 0.01, 0, 0.2}, 0));
}

TEST(ArrangementTest, AnObjectOnTopIsNotInTheWay) {
  Arrangement arrangement;
  arrangement.occupy({0, 0, 0, 0.1, 0.1, 0, 0.2});
  EXPECT_TRUE(arrangement.is_free({0, 0, 0, 0.1, 0.1, 0.2, 0.4}, 0.01));
  EXPECT_FALSE(arrangement.is_free({0, 0, 0, 0.1, 0.1, 0.19, 0.4}, 0.01));
}

class PlaceObjectsTest : public testing::TestWithParam<int> {};

TEST_P(PlaceObjectsTest, NothingIntersectsAndEverythingStandsOnSomething) {
  Random random(static_cast<std::uint64_t>(GetParam()));
  Arrangement arrangement;
  World world;
  const Shelf shelf{translated({0, 0, 0}), 0.45, 0.37};
  const std::uint32_t next = place_objects(25, shelf, {0.005, 0.4}, 20, random, arrangement, world);
  const auto& boxes = arrangement.occupied();
  ASSERT_GE(boxes.size(), 15U);
  EXPECT_EQ(next, 20 + 10 * boxes.size());
  std::set<std::uint32_t> labels;
  for (const Solid& solid : world) labels.insert(solid.label);
  EXPECT_EQ(labels.size(), boxes.size());

  int stacked = 0;
  for (std::size_t i = 0; i < boxes.size(); ++i) {
    const Footprint& box = boxes[i];
    const Pose pose = rotated(box.turns, {box.x, box.y, 0});
    for (int k = 0; k < 300; ++k) {
      const double x = random.uniform(-1, 1) * box.half_x, y = random.uniform(-1, 1) * box.half_y;
      const Vec3 p = pose.to_parent({x, y, random.uniform(box.bottom, box.top)});
      for (std::size_t j = 0; j < boxes.size(); ++j) {
        ASSERT_TRUE(j == i || !contains(boxes[j], p)) << i << " intersects " << j;
      }
    }
    if (box.bottom == 0) continue;
    ++stacked;
    const Vec3 below{box.x, box.y, box.bottom - 1e-4};
    EXPECT_TRUE(std::any_of(boxes.begin(), boxes.end(), [&](const Footprint& b) { return contains(b, below); }));
  }
  EXPECT_GT(stacked, 0);
}

INSTANTIATE_TEST_SUITE_P(Seeds, PlaceObjectsTest, testing::Range(1, 7));

TEST(PlaceObjectsTest, ObjectsStayBelowTheNextBoard) {
  Random random(9);
  Arrangement arrangement;
  World world;
  const Shelf shelf{translated({0, 0, 1}), 0.45, 0.16, 0.12};
  place_objects(10, shelf, {0.005, 0.5}, 20, random, arrangement, world);
  ASSERT_FALSE(arrangement.occupied().empty());
  for (const Footprint& box : arrangement.occupied()) EXPECT_LE(box.top, 1.12);
}

}  // namespace
}  // namespace segserve::synth
