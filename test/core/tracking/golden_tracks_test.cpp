// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include "core/lab/synth/moving_tabletop.hpp"
#include "segserve/segment.hpp"
#include "segserve/tracking.hpp"

namespace segserve {
namespace {

std::uint64_t checksum(const std::string& bytes) {
  std::uint64_t hash = 0xCBF29CE484222325U;
  for (const char c : bytes) hash = (hash ^ static_cast<std::uint8_t>(c)) * 0x100000001B3U;
  return hash;
}

// The bytes of the states are the same on every CPU and with every compiler; see decision 2.
TEST(TrackGolden, FollowsAMovingSceneToTheSameBytes) {
  synth::MovingOptions options;
  options.scene.width = 160, options.scene.height = 120;
  options.scene.clutter = 0;
  const auto scene = synth::MovingTabletop::make(options);
  for (const bool with_poses : {true, false}) {
    Segmenter segmenter;
    TrackState state;
    for (std::uint32_t i = 0; i < 6; ++i) {
      const synth::MovingFrame frame = scene->frame(i);
      const auto segmentation = segmenter.segment(frame.scene.cloud, {});
      ASSERT_TRUE(segmentation.ok()) << segmentation.status();
      TrackOptions track_options;
      track_options.time = frame.time;
      if (with_poses) track_options.pose = frame.pose;
      const auto tracking = track(*segmentation, frame.scene.cloud.view, state, track_options);
      ASSERT_TRUE(tracking.ok()) << tracking.status();
      state = tracking->state;
    }
    EXPECT_GE(state.tracks.size(), 5U);
    EXPECT_EQ(checksum(state.bytes()), with_poses ? 0xA9F7A5B921393A6EU : 0x1684635DAE884393U)
        << std::hex << checksum(state.bytes());
  }
}

}  // namespace
}  // namespace segserve
