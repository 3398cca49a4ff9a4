// SPDX-License-Identifier: Apache-2.0
#include <gmock/gmock.h>

#include <cmath>
#include <limits>
#include <map>

#include "core/lab/synth/scene.hpp"
#include "test/core/lab/synth/checksum.hpp"

namespace segserve::synth {
namespace {

using testing::AllOf;
using testing::HasSubstr;

SyntheticScene make_view(const RoomViewOptions& options) {
  auto scene = make_room_view(options);
  EXPECT_TRUE(scene.ok()) << scene.status();
  return *std::move(scene);
}

// See TabletopTest.GoldenChecksum.
TEST(RoomViewTest, GoldenChecksum) {
  EXPECT_EQ(checksum(make_view({.width = 160, .height = 120})), 5204674662541516257U);
  EXPECT_EQ(checksum(make_view({.seed = 2, .width = 160, .height = 120, .sensor = Sensor::kStereo})),
            5394186418689512049U);
  EXPECT_EQ(checksum(make_view({.seed = 3, .width = 160, .height = 120, .sensor = Sensor::kPassiveStereo})),
            6240611979825180489U);
  EXPECT_EQ(checksum(make_view({.seed = 4, .width = 160, .height = 120, .sensor = Sensor::kTimeOfFlight})),
            8432002160991274325U);
  EXPECT_EQ(checksum(make_view({.seed = 5, .width = 160, .height = 120, .sensor = Sensor::kIdeal})),
            6356458035347674452U);
}

class RoomViewSeedTest : public testing::TestWithParam<std::uint64_t> {};

TEST_P(RoomViewSeedTest, SeesFloorWallsAndFurnitureFarAway) {
  const SyntheticScene scene = make_view({.seed = GetParam(), .width = 320, .height = 240, .sensor = Sensor::kIdeal});
  EXPECT_EQ(scene.cloud.view, View::camera());
  EXPECT_TRUE(check_shape(scene.cloud).ok());
  ASSERT_TRUE(scene.camera.has_value());
  EXPECT_EQ(scene.camera->fx, 262.5);
  std::map<std::uint32_t, std::size_t> points;
  std::size_t far = 0;
  for (std::size_t i = 0; i < scene.label.size(); ++i) {
    ++points[scene.label[i]];
    far += scene.cloud.z[i] > 6 ? 1 : 0;
  }
  EXPECT_EQ(points.count(0), 0U);  // The room is closed, and the sensor ideal.
  EXPECT_GT(far, 2000U);
  EXPECT_GT(points[1], 5000U);
  std::size_t walls = 0, objects = 0;
  for (const auto& [label, n] : points) {
    walls += label >= 2 && label <= 5 && n > 2000 ? 1 : 0;
    objects += label >= 20 && label % 10 == 0 ? 1 : 0;
  }
  EXPECT_GE(walls, 2U);
  EXPECT_GE(objects, 8U);
}
INSTANTIATE_TEST_SUITE_P(Seeds, RoomViewSeedTest, testing::Range<std::uint64_t>(1, 7));

// All sensors see the same room; they differ in what they measure of it.
TEST(RoomViewTest, SensorsDifferInDepthsAndNotInTheScene) {
  const auto of = [](Sensor sensor) { return make_view({.width = 320, .height = 240, .sensor = sensor}); };
  const SyntheticScene ideal = of(Sensor::kIdeal);
  for (const Sensor sensor : {Sensor::kKinect1, Sensor::kStereo, Sensor::kPassiveStereo, Sensor::kTimeOfFlight}) {
    const SyntheticScene scene = of(sensor);
    EXPECT_EQ(scene.cloud.rgb, ideal.cloud.rgb);
    std::size_t labeled = 0, same = 0, moved = 0;
    for (std::size_t i = 0; i < scene.label.size(); ++i) {
      if (scene.label[i] == 0) continue;
      ++labeled;
      same += scene.label[i] / 10 == ideal.label[i] / 10 ? 1 : 0;
      moved += scene.cloud.z[i] != ideal.cloud.z[i] ? 1 : 0;
    }
    EXPECT_GT(labeled, scene.label.size() / 2);
    EXPECT_GT(same, labeled * 9 / 10);
    EXPECT_GT(moved, labeled * 9 / 10);
  }
}

TEST(RoomViewOptionsTest, EveryWrongOptionIsNamed) {
  const auto status =
      make_room_view({.height = 5000, .size = 0.1, .noise = std::numeric_limits<double>::quiet_NaN()}).status();
  EXPECT_EQ(status.code(), absl::StatusCode::kInvalidArgument);
  EXPECT_THAT(std::string(status.message()),
              AllOf(HasSubstr("height is 5000, must be in [16, 4096]"), HasSubstr("size is 0.1"), HasSubstr("noise")));
}

}  // namespace
}  // namespace segserve::synth
