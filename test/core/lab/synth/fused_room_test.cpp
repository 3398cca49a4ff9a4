// SPDX-License-Identifier: Apache-2.0
#include <gmock/gmock.h>

#include <cmath>
#include <limits>
#include <map>
#include <unordered_set>

#include "core/lab/synth/scene.hpp"
#include "test/core/lab/synth/checksum.hpp"

namespace segserve::synth {
namespace {

using testing::AllOf;
using testing::HasSubstr;

SyntheticScene make_room(const RoomOptions& options) {
  auto scene = make_fused_room(options);
  EXPECT_TRUE(scene.ok()) << scene.status();
  return *std::move(scene);
}

// See TabletopTest.GoldenChecksum.
TEST(FusedRoomTest, GoldenChecksum) {
  EXPECT_EQ(checksum(make_room({.points = 50000})), 15799403824969860548U);
  EXPECT_EQ(checksum(make_room({.seed = 4, .points = 30000, .size = 1.5, .objects = 30, .noise = 2})),
            7925495342641705968U);
}

class RoomPointsTest : public testing::TestWithParam<std::uint32_t> {};

TEST_P(RoomPointsTest, HasExactlyThePointsAskedFor) {
  const SyntheticScene scene = make_room({.seed = 3, .points = GetParam()});
  EXPECT_EQ(scene.cloud.size(), GetParam());
  EXPECT_EQ(scene.label.size(), GetParam());
  EXPECT_EQ(scene.cloud.height, 1U);
  EXPECT_TRUE(check_shape(scene.cloud).ok());
}
INSTANTIATE_TEST_SUITE_P(Points, RoomPointsTest, testing::Values(1000U, 12345U, 100000U, 1000003U));

TEST(FusedRoomTest, IsARoomOfFinitePointsAroundItsSensor) {
  const SyntheticScene scene = make_room({.points = 100000});
  ASSERT_EQ(scene.cloud.view.kind, ViewKind::kWorld);
  ASSERT_TRUE(scene.cloud.view.sensor.has_value());
  EXPECT_NEAR((*scene.cloud.view.sensor)[2], 1.45, 0.3);
  for (std::size_t i = 0; i < scene.cloud.size(); ++i) {
    ASSERT_LE(std::abs(scene.cloud.x[i]), 1.65 + 0.05);
    ASSERT_LE(std::abs(scene.cloud.y[i]), 1.40 + 0.05);
    ASSERT_GE(scene.cloud.z[i], -0.05);
    ASSERT_LE(scene.cloud.z[i], 2.45);
  }
}

TEST(FusedRoomTest, EveryWallTheFloorAndFurnitureAreSeen) {
  std::map<std::uint32_t, std::size_t> points;
  for (const std::uint32_t label : make_room({.points = 200000}).label) ++points[label];
  for (std::uint32_t label = 1; label <= 5; ++label) EXPECT_GT(points[label], 5000U) << label;
  std::size_t objects = 0;
  for (const auto& [label, n] : points) {
    if (label < 20) continue;
    EXPECT_EQ(label % 10, 0U);
    ++objects;
  }
  EXPECT_GE(objects, 12U);
}

// One surface: without noise the floor's points lie in the floor, and no cell of the spacing holds many.
TEST(FusedRoomTest, ViewsAreFusedIntoOneThinSurface) {
  const SyntheticScene perfect = make_room({.points = 100000, .noise = 0});
  const SyntheticScene noisy = make_room({.points = 100000});
  double squares = 0;
  std::size_t floor = 0;
  for (std::size_t i = 0; i < noisy.label.size(); ++i) {
    ASSERT_TRUE(perfect.label[i] != 1 || std::abs(perfect.cloud.z[i]) < 1e-5);
    if (noisy.label[i] != 1) continue;
    squares += static_cast<double>(noisy.cloud.z[i]) * noisy.cloud.z[i];
    ++floor;
  }
  const double deviation = std::sqrt(squares / static_cast<double>(floor));
  EXPECT_GT(deviation, 0.0002);
  EXPECT_LT(deviation, 0.003);

  std::unordered_set<std::uint64_t> cells;
  for (std::size_t i = 0; i < perfect.label.size(); ++i) {
    const auto cell = [](float value) { return static_cast<std::uint64_t>(std::llround((value + 10) / 0.01)); };
    cells.insert(cell(perfect.cloud.x[i]) << 42U | cell(perfect.cloud.y[i]) << 21U | cell(perfect.cloud.z[i]));
  }
  EXPECT_GT(cells.size(), perfect.label.size() * 3 / 4);  // duplicates would share cells
}

TEST(FusedRoomTest, FurnitureGrowsWithTheFloor) {
  const auto objects = [](double size) {
    std::unordered_set<std::uint32_t> labels;
    for (const std::uint32_t label : make_room({.points = 100000, .size = size, .objects = 0}).label) {
      if (label >= 20) labels.insert(label);
    }
    return labels.size();
  };
  EXPECT_GT(objects(3), 4 * objects(1));
}

TEST(FusedRoomTest, MoreFurnitureHasAGoldenChecksumAndMoreObjects) {
  const auto objects = [](const SyntheticScene& scene) {
    std::unordered_set<std::uint32_t> labels;
    for (const std::uint32_t label : scene.label) {
      if (label >= 20) labels.insert(label);
    }
    return labels.size();
  };
  const SyntheticScene usual = make_room({.points = 50000, .size = 1.6, .objects = 0});
  const SyntheticScene furnished = make_room({.points = 50000, .size = 1.6, .objects = 0, .furnished = true});
  EXPECT_EQ(checksum(furnished), 9297915303639116672U);
  EXPECT_GE(objects(furnished), objects(usual) + 6);
}

TEST(RoomOptionsTest, EveryWrongOptionIsNamed) {
  const auto status = make_fused_room({.points = 10, .size = 11, .noise = -1}).status();
  EXPECT_EQ(status.code(), absl::StatusCode::kInvalidArgument);
  EXPECT_THAT(std::string(status.message()), AllOf(HasSubstr("points is 10, must be in [1000, 20000000]"),
                                                   HasSubstr("size is 11"), HasSubstr("noise is -1")));
}

}  // namespace
}  // namespace segserve::synth
