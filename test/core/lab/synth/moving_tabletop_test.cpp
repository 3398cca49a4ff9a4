// SPDX-License-Identifier: Apache-2.0
#include "core/lab/synth/moving_tabletop.hpp"

#include <gmock/gmock.h>

#include <map>
#include <set>

#include "core/base/status_text.hpp"

namespace segserve::synth {
namespace {

MovingOptions small(double rate = 10) {
  MovingOptions options;
  options.scene.width = 160, options.scene.height = 120;
  options.scene.seed = 5;
  options.scene.clutter = 0;
  options.scene.sensor = Sensor::kIdeal;
  options.rate = rate;
  return options;
}

std::vector<std::uint32_t> bits(const SyntheticScene& scene) {
  std::vector<std::uint32_t> result = scene.label;
  for (const float z : scene.cloud.z) result.push_back(std::bit_cast<std::uint32_t>(z));
  result.insert(result.end(), scene.cloud.rgb.begin(), scene.cloud.rgb.end());
  return result;
}

/// The mean position of each object in the frame of the table.
std::map<std::uint32_t, Eigen::Vector3d> places(const MovingFrame& frame) {
  std::map<std::uint32_t, Eigen::Vector3d> sum;
  std::map<std::uint32_t, double> count;
  const Cloud& cloud = frame.scene.cloud;
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    if (frame.scene.label[i] < kFirstObject) continue;
    const Eigen::Vector3d point(cloud.x[i], cloud.y[i], cloud.z[i]);
    sum.try_emplace(frame.scene.label[i], Eigen::Vector3d::Zero()).first->second +=
        frame.pose.rotation * point + frame.pose.translation;
    count[frame.scene.label[i]] += 1;
  }
  for (auto& [label, place] : sum) place /= count[label];
  return sum;
}

TEST(MovingTabletop, MakesTheSameFramesInAnyOrder) {
  const auto a = MovingTabletop::make(small()), b = MovingTabletop::make(small());
  ASSERT_TRUE(a.ok() && b.ok());
  const auto late = bits(a->frame(7).scene);
  EXPECT_EQ(bits(b->frame(3).scene), bits(a->frame(3).scene));
  EXPECT_EQ(bits(b->frame(7).scene), late);
  EXPECT_NE(bits(b->frame(8).scene), late);
}

TEST(MovingTabletop, MovesAlikeAtAnyRate) {
  const auto fast = MovingTabletop::make(small(30)), slow = MovingTabletop::make(small(3));
  const MovingFrame a = fast->frame(20), b = slow->frame(2);
  EXPECT_DOUBLE_EQ(a.time, b.time);
  EXPECT_TRUE(a.pose.translation.isApprox(b.pose.translation));
  EXPECT_EQ(a.scene.label, b.scene.label);
}

TEST(MovingTabletop, MovesSomeObjectsAndLetsTheOthersRest) {
  const auto scene = MovingTabletop::make(small());
  ASSERT_EQ(scene->moving(), 2);
  const auto before = places(scene->frame(0)), after = places(scene->frame(12));
  std::size_t moved = 0;
  for (const auto& [label, place] : after) {
    if (!before.contains(label)) continue;
    // The visible part of an object that rests changes with the view by a centimeter or so.
    moved += (place - before.at(label)).head<2>().norm() > 0.04 ? 1 : 0;
  }
  EXPECT_GE(moved, 1);
  EXPECT_LE(moved, 2);
}

TEST(MovingTabletop, MovesTheCamera) {
  const auto scene = MovingTabletop::make(small());
  EXPECT_GT((scene->frame(10).pose.translation - scene->frame(0).pose.translation).norm(), 0.02);
  MovingOptions still = small();
  still.camera_motion = 0;
  const auto resting = MovingTabletop::make(still);
  EXPECT_TRUE(resting->frame(10).pose.translation.isApprox(resting->frame(0).pose.translation));
}

TEST(MovingTabletop, NamesAllWrongOptions) {
  MovingOptions options;
  options.rate = 0, options.frames = 0, options.camera_motion = -1, options.moving = 41, options.speed = 3;
  options.scene.clutter = 2;
  const std::string message = message_of(MovingTabletop::make(options).status());
  for (const char* name : {"rate", "frames", "camera_motion", "moving", "speed", "clutter"}) {
    EXPECT_THAT(message, testing::HasSubstr(name));
  }
}

}  // namespace
}  // namespace segserve::synth
