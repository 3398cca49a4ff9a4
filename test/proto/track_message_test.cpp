// SPDX-License-Identifier: Apache-2.0
#include "proto/wire/track_message.hpp"

#include <gmock/gmock.h>

#include <limits>

#include "core/base/status_text.hpp"

namespace segserve::wire {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

TrackRequest example() {
  TrackRequest request;
  TrackState state;
  state.next_id = 7;
  request.state = state.bytes();
  request.options.pose = RigidTransform{};
  request.options.pose->translation = {1, 2, 3};
  request.options.time = 12.25;
  request.options.max_speed = 2;
  request.options.keep_lost = 0;
  request.options.min_points = 5;
  return request;
}

std::vector<std::string> faulty_fields(const v1::TrackRequest& message) {
  std::vector<FieldViolation> faults;
  from_message(message, faults);
  std::vector<std::string> fields;
  for (const FieldViolation& fault : faults) fields.push_back(fault.field);
  return fields;
}

TEST(TrackMessage, OfARequestComesBack) {
  std::vector<FieldViolation> faults;
  EXPECT_EQ(from_message(to_message(example()), faults), example());
  EXPECT_EQ(from_message(v1::TrackRequest(), faults), TrackRequest());
  EXPECT_THAT(faults, IsEmpty());
}

TEST(TrackMessage, NamesAllWrongFields) {
  v1::TrackRequest message = to_message(example());
  message.set_state("no state");
  message.mutable_pose()->set_rotation(0, 2);
  message.set_time(std::numeric_limits<double>::infinity());
  message.set_max_speed(-1);
  message.set_keep_lost(1001);
  message.set_min_points(0);
  EXPECT_THAT(faulty_fields(message), ElementsAre("tracking.state", "tracking.pose", "tracking.time",
                                                  "tracking.max_speed", "tracking.keep_lost", "tracking.min_points"));
  message = to_message(example());
  message.mutable_pose()->add_rotation(0);
  EXPECT_THAT(faulty_fields(message), ElementsAre("tracking.pose.rotation"));
}

TEST(TrackMessage, OfAResultComesBack) {
  const Tracks tracks{.state = "state",
                      .track_of_segment = {3, 0, 9},
                      .events = {{TrackEventKind::kBorn, 3}, {TrackEventKind::kMerged, 4, 9}}};
  EXPECT_EQ(*from_message(to_message(tracks), 3), tracks);
}

TEST(TrackMessage, OfAResultIsChecked) {
  const Tracks tracks{.state = "state", .track_of_segment = {3, 0, 0}, .events = {}};
  EXPECT_THAT(message_of(from_message(to_message(tracks), 2).status()), HasSubstr("ids of 3 segments, but 2"));
  v1::TrackResult twice = to_message(tracks);
  twice.set_track_ids(2, 3);
  EXPECT_THAT(message_of(from_message(twice, 3).status()), HasSubstr("the same id"));
  v1::TrackResult large = to_message(tracks);
  large.set_state(std::string(TrackState::kMostBytes + 1, 'x'));
  EXPECT_THAT(message_of(from_message(large, 3).status()), HasSubstr("too large"));
  v1::TrackResult later = to_message(tracks);
  later.add_events()->set_kind(static_cast<v1::TrackEventKind>(99));
  EXPECT_EQ(*from_message(later, 3), tracks) << "events of later versions are left out";
}

}  // namespace
}  // namespace segserve::wire
