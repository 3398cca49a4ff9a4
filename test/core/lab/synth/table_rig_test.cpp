// SPDX-License-Identifier: Apache-2.0
#include "core/lab/synth/table_rig.hpp"

#include <gmock/gmock.h>

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <set>
#include <string>

#include "segserve/cameras.hpp"

namespace segserve::synth {
namespace {

SceneOptions small_table() {
  return {
      .seed = 2, .width = 160, .height = 120, .objects = 4, .clutter = 0, .compact = true, .sensor = Sensor::kIdeal};
}

TEST(TableRig, CamerasStandAroundTheTableAtEqualAngles) {
  const auto views = make_tabletop_rig(small_table(), 3);
  ASSERT_TRUE(views.ok()) << views.status();
  ASSERT_EQ(views->size(), 3U);
  const Eigen::Vector3d first = (*views)[0].pose.translation;
  for (std::size_t c = 0; c < 3; ++c) {
    const RigidTransform& pose = (*views)[c].pose;
    EXPECT_FALSE(fault_of_transform(pose));
    const Eigen::Vector3d next = (*views)[(c + 1) % 3].pose.translation;
    EXPECT_NEAR(pose.translation.z(), first.z(), 1e-9);
    EXPECT_NEAR(pose.translation.head<2>().dot(next.head<2>()), -0.5 * first.head<2>().squaredNorm(), 1e-9);
  }
}

TEST(TableRig, AllCamerasSeeTheSameTableAndObjects) {
  const auto views = make_tabletop_rig(small_table(), 2);
  ASSERT_TRUE(views.ok()) << views.status();
  for (const RigView& view : *views) {
    std::set<std::uint32_t> labels(view.scene.label.begin(), view.scene.label.end());
    EXPECT_THAT(labels, testing::IsSupersetOf({1U, 20U, 30U, 40U, 50U}));
    // In the shared frame the top of the table is at z = 0.
    const Cloud& cloud = view.scene.cloud;
    EXPECT_EQ(cloud.view, View::camera());
    for (std::size_t i = 0; i < cloud.size(); ++i) {
      const Eigen::Vector3d point(cloud.x[i], cloud.y[i], cloud.z[i]);
      const double height = (view.pose.rotation * point + view.pose.translation).z();
      if (view.scene.label[i] >= 20) {
        ASSERT_GT(height, -1e-4);
      } else if (view.scene.label[i] == 1) {
        ASSERT_LT(height, 1e-4);
      }
    }
  }
}

TEST(TableRig, TheSameOptionsGiveTheSameBytes) {
  SceneOptions options = small_table();
  options.sensor = Sensor::kKinect1;
  const auto once = make_tabletop_rig(options, 2), again = make_tabletop_rig(options, 2);
  ASSERT_TRUE(once.ok() && again.ok());
  EXPECT_EQ((*once)[1].scene.cloud.rgb, (*again)[1].scene.cloud.rgb);
  EXPECT_EQ((*once)[1].scene.label, (*again)[1].scene.label);
  EXPECT_NE((*once)[0].scene.cloud.rgb, (*once)[1].scene.cloud.rgb);
}

TEST(TableRig, NamesWhatIsOutOfRange) {
  const auto error = [](const SceneOptions& options, std::uint32_t cameras) {
    return std::string(make_tabletop_rig(options, cameras).status().message());
  };
  EXPECT_THAT(error(small_table(), 0), testing::HasSubstr("cameras: 0 is not from 1 to 16"));
  EXPECT_THAT(error(small_table(), 17), testing::HasSubstr("cameras: 17"));
  SceneOptions options = small_table();
  options.width = 1;
  EXPECT_THAT(error(options, 2), testing::HasSubstr("width"));
  options = small_table();
  options.all_finite = true;
  EXPECT_THAT(error(options, 2), testing::HasSubstr("all_finite"));
}

}  // namespace
}  // namespace segserve::synth
