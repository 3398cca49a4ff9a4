// SPDX-License-Identifier: Apache-2.0
#include <string>

#include "core/lab/synth/moving_tabletop.hpp"
#include "gmock/gmock.h"
#include "proto/wire/track_message.hpp"
#include "test/server/support/running_server.hpp"
#include "test/server/support/server_scenes.hpp"

namespace segserve::server {
namespace {

using testing::Each;
using testing::HasSubstr;
using testing::Not;

synth::MovingTabletop scene() {
  synth::MovingOptions options;
  options.scene.width = 160, options.scene.height = 120;
  options.scene.clutter = 0;
  return *synth::MovingTabletop::make(options);
}

v1::SegmentRequest request_of(const synth::MovingFrame& frame, const std::string& state) {
  v1::SegmentRequest request = request_for(frame.scene.cloud, v1::COMPRESSION_ZSTD);
  wire::TrackRequest tracking{.options = {}, .state = state};
  tracking.options.time = frame.time;
  tracking.options.min_points = 30;
  *request.mutable_tracking() = wire::to_message(tracking);
  return request;
}

TEST(Tracking, IsTheSameFromAnyServer) {
  RunningServer a, b;
  const synth::MovingTabletop moving = scene();
  std::string state;
  for (std::uint32_t i = 0; i < 4; ++i) {
    const v1::SegmentRequest request = request_of(moving.frame(i), state);
    const auto from_a = a.segment(request), from_b = b.segment(request);
    ASSERT_TRUE(from_a.ok() && from_b.ok()) << from_a.status() << from_b.status();
    EXPECT_EQ(from_a->result().labels().SerializeAsString(), from_b->result().labels().SerializeAsString());
    EXPECT_EQ(from_a->result().tracking().SerializeAsString(), from_b->result().tracking().SerializeAsString());
    const v1::TrackResult& tracking = from_a->result().tracking();
    EXPECT_EQ(static_cast<std::uint32_t>(tracking.track_ids_size()), from_a->result().summary().segments());
    EXPECT_EQ(tracking.track_ids(0), 1U) << "the table stays the table";
    if (i > 0) {
      EXPECT_GT(from_a->result().summary().timings().tracking_ms(), 0);
    }
    state = tracking.state();
  }
}

TEST(Tracking, IsThereOnlyIfAskedFor) {
  RunningServer server;
  const auto response = server.segment(request_for(wall_with_box(), v1::COMPRESSION_NONE));
  ASSERT_TRUE(response.ok()) << response.status();
  EXPECT_FALSE(response->result().has_tracking());
  EXPECT_EQ(response->result().summary().timings().tracking_ms(), 0);
}

TEST(Tracking, DescribesTheSegmentsThatItMade) {
  RunningServer server;
  v1::SegmentRequest request = request_of(scene().frame(0), "");
  request.mutable_outputs()->set_labels(true);
  request.mutable_outputs()->set_segments(true);
  const auto response = server.segment(request);
  ASSERT_TRUE(response.ok()) << response.status();
  EXPECT_EQ(static_cast<std::uint32_t>(response->result().segments_size()), response->result().summary().segments());
}

TEST(Tracking, RefusesAStateThatIsNone) {
  RunningServer server;
  v1::SegmentRequest request = request_of(scene().frame(0), "");
  request.mutable_tracking()->set_state("SGTS and something else that is long enough");
  request.mutable_tracking()->set_max_speed(-1);
  const auto response = server.segment(request);
  EXPECT_EQ(response.status().code(), absl::StatusCode::kInvalidArgument);
  EXPECT_THAT(std::string(response.status().message()), HasSubstr("tracking.state"));
  EXPECT_THAT(std::string(response.status().message()), HasSubstr("tracking.max_speed"));
}

}  // namespace
}  // namespace segserve::server
