// SPDX-License-Identifier: Apache-2.0
#include "segserve/cameras.hpp"

#include <gmock/gmock.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>
#include <vector>

#include "test/core/support/clouds.hpp"

namespace segserve {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;

/// A quarter turn about z, and a shift.
RigidTransform turned() {
  RigidTransform pose;
  pose.rotation << 0, -1, 0, 1, 0, 0, 0, 0, 1;
  pose.translation = {10, 20, 30};
  return pose;
}

Cloud two_points(const View& view) {
  Cloud cloud = test::unorganized(view);
  test::add(cloud, 1, 2, 3, 0x111111);
  test::add(cloud, 0, 0, 0, 0x222222);
  return cloud;
}

std::string merge_error(const std::vector<CameraCloud>& cameras) {
  const auto merged = merge_cameras(cameras);
  EXPECT_EQ(merged.status().code(), absl::StatusCode::kInvalidArgument);
  return std::string(merged.status().message());
}

TEST(MergeCameras, MovesPointsAndSensorsToTheSharedFrame) {
  const Cloud camera = two_points(View::camera()), world = two_points(View::world(0, 0, 5));
  const auto merged = merge_cameras(std::vector<CameraCloud>{{camera, turned()}, {world, {}}});
  ASSERT_TRUE(merged.ok()) << merged.status();
  EXPECT_TRUE(check_shape(*merged).ok()) << check_shape(*merged);
  EXPECT_EQ(merged->width, 4U);
  EXPECT_EQ(merged->height, 1U);
  EXPECT_EQ(merged->x[0], 8);
  EXPECT_EQ(merged->y[0], 21);
  EXPECT_EQ(merged->z[0], 33);
  EXPECT_TRUE(std::isnan(merged->x[1])) << "a pixel without depth is no point";
  EXPECT_EQ(merged->z[2], 3);
  EXPECT_EQ(merged->x[3], 0) << "the origin is a point like any other in a WORLD view";
  EXPECT_THAT(merged->rgb, ElementsAre(0x111111, 0x222222, 0x111111, 0x222222));
  EXPECT_THAT(merged->view.cameras, ElementsAre(CameraPoints{2, {10, 20, 30}}, CameraPoints{2, {0, 0, 5}}));
}

TEST(MergeCameras, NamesTheCameraThatIsWrong) {
  const Cloud good = two_points(View::camera()), no_sensor = two_points(View::world());
  EXPECT_THAT(merge_error({}), HasSubstr("there is no camera"));
  EXPECT_THAT(merge_error(std::vector<CameraCloud>(65, {good, {}})), HasSubstr("65 cameras, but at most 64"));
  EXPECT_THAT(merge_error({{good, {}}, {no_sensor, {}}}),
              HasSubstr("camera 1: the cloud has a WORLD view that does not"));
  EXPECT_THAT(merge_error({{Cloud(), {}}}), HasSubstr("camera 0: the cloud is empty"));
  const auto merged = merge_cameras(std::vector<CameraCloud>{{good, {}}});
  ASSERT_TRUE(merged.ok());
  EXPECT_THAT(merge_error({{*merged, {}}}), HasSubstr("camera 0: the cloud is itself of several cameras"));

  Cloud colorless = good;
  colorless.rgb.clear();
  EXPECT_THAT(merge_error({{good, {}}, {colorless, {}}}), HasSubstr("camera 1: the cloud has no color"));
  EXPECT_THAT(merge_error({{colorless, {}}, {good, {}}}), HasSubstr("camera 1: the cloud has color"));

  RigidTransform pose;
  pose.translation.x() = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THAT(merge_error({{good, pose}}), HasSubstr("camera 0: the pose is not finite"));
  pose = {};
  pose.rotation(0, 0) = 1.01;
  EXPECT_THAT(merge_error({{good, pose}}), HasSubstr("not orthonormal"));
  pose.rotation(0, 0) = -1;
  EXPECT_THAT(merge_error({{good, pose}}), HasSubstr("mirror image"));
}

TEST(SplitByCamera, GivesTheValuesOfEachCameraInItsOrder) {
  const View view = View::of_cameras({{2, {0, 0, 1}}, {3, {0, 0, 2}}});
  const std::vector<std::uint32_t> labels{1, 2, 3, 4, 5};
  const auto parts = split_by_camera(view, labels);
  ASSERT_TRUE(parts.ok()) << parts.status();
  ASSERT_EQ(parts->size(), 2U);
  EXPECT_THAT((*parts)[0], ElementsAre(1, 2));
  EXPECT_THAT((*parts)[1], ElementsAre(3, 4, 5));
  EXPECT_EQ(split_by_camera(View::world(), labels).status().message(), "the view has no cameras");
  EXPECT_THAT(std::string(split_by_camera(view, std::span(labels).first(4)).status().message()),
              HasSubstr("the cameras have 5 points together, but the cloud has 4"));
}

TEST(CheckShape, RefusesCamerasThatDoNotFit) {
  Cloud cloud = two_points(View::of_cameras({{1, {0, 0, 1}}, {1, {0, 0, 2}}}));
  EXPECT_TRUE(check_shape(cloud).ok()) << check_shape(cloud);
  const auto fault = [&](View view) {
    cloud.view = std::move(view);
    return std::string(check_shape(cloud).message());
  };
  EXPECT_THAT(fault(View::of_cameras({{1, {0, 0, 1}}})), HasSubstr("the cameras have 1 points together"));
  EXPECT_THAT(fault(View::of_cameras({{0, {0, 0, 1}}, {2, {0, 0, 1}}})), HasSubstr("camera 0 has no points"));
  EXPECT_THAT(fault(View::of_cameras({{1, {0, 0, 1}}, {1, {0, NAN, 1}}})), HasSubstr("camera 1 is not finite"));
  EXPECT_THAT(fault({ViewKind::kCamera, std::nullopt, {{2, {0, 0, 1}}}}), HasSubstr("need a WORLD view"));
  EXPECT_THAT(fault({ViewKind::kWorld, Eigen::Vector3f(0, 0, 1), {{2, {0, 0, 1}}}}), HasSubstr("both a sensor"));
  EXPECT_THAT(fault(View::of_cameras(std::vector<CameraPoints>(65, {1, {0, 0, 1}}))), HasSubstr("at most 64"));
}

}  // namespace
}  // namespace segserve
