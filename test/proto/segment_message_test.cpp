// SPDX-License-Identifier: Apache-2.0
#include "proto/wire/segment_message.hpp"

#include <functional>
#include <limits>
#include <string>

#include "gmock/gmock.h"
#include "proto/wire/status_message.hpp"
#include "segserve/v1/result.pb.h"
#include "test/proto/example_messages.hpp"

namespace segserve::wire {
namespace {

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
constexpr double kInfinity = std::numeric_limits<double>::infinity();

std::string refusal(const SegmentMessages& messages, std::uint32_t segments = 2, std::uint64_t points = 5) {
  const absl::Status status = from_message(messages, segments, points).status();
  EXPECT_EQ(details_of(status).reason, ErrorReason::kMalformedPayload) << status;
  return std::string(status.message());
}

TEST(WireSegments, RoundTrip) {
  const auto read = from_message(to_message(small_statistics()), 2, 5);
  ASSERT_TRUE(read.ok()) << read.status();
  EXPECT_EQ(*read, small_statistics());
  EXPECT_TRUE(from_message({}, 0, 0)->empty());
}

TEST(WireSegments, MustBeCompleteAndAddUp) {
  const SegmentMessages messages = to_message(small_statistics());
  EXPECT_THAT(refusal(messages, 3), testing::HasSubstr("segments: has 2 entries, but must have 3"));
  EXPECT_THAT(refusal(messages, 1), testing::HasSubstr("segments: has 2 entries, but must have 1"));
  EXPECT_THAT(refusal({}), testing::HasSubstr("segments: has 0 entries, but must have 2"));
  EXPECT_THAT(refusal(messages, 2, 6),
              testing::HasSubstr("2 segments have 5 points, but by the summary 2 segments have 6 points"));
  EXPECT_THAT(refusal(messages, 2, 4),
              testing::HasSubstr("2 segments have 5 points, but by the summary 2 segments have 4 points"));
}

TEST(WireSegments, AreTheLargestIfThereAreTooMany) {
  std::vector<SegmentStatistics> many(kMostDescribedSegments, small_statistics()[1]);
  EXPECT_TRUE(from_message(to_message(many), kMostDescribedSegments + 3, kMostDescribedSegments + 3).ok());
  EXPECT_THAT(
      refusal(to_message(many), kMostDescribedSegments + 3, kMostDescribedSegments + 2),
      testing::HasSubstr("10000 segments have 10000 points, but by the summary 10003 segments have 10002 points"));
  many.push_back(many[0]);
  EXPECT_THAT(refusal(to_message(many), kMostDescribedSegments + 1, kMostDescribedSegments + 1),
              testing::HasSubstr("segments: has 10001 entries, but must have 10000"));
}

TEST(WireSegments, FitAMessageOfTheSizeThatClientsReadByDefault) {
  constexpr std::size_t kDefaultReceiveBytes = 4 << 20;
  SegmentStatistics large = small_statistics()[0];
  large.points = 0x7fffffff;
  const double third = 1.0 / 3;  // A zero would take no bytes in the message.
  large.box.axes.setConstant(third);
  for (Eigen::Vector3d* v :
       {&large.centroid, &large.box.center, &large.box.half_extents, &*large.color, &*large.normal}) {
    v->setConstant(third);
  }
  v1::SegmentationResult result;
  *result.mutable_segments() = to_message(std::vector<SegmentStatistics>(kMostDescribedSegments, large));
  EXPECT_LT(result.ByteSizeLong(), kDefaultReceiveBytes / 8 * 5) << "the rest is for summary and header";
}

TEST(WireSegments, RefusesValuesThatNoSegmentHas) {
  using Damage = std::function<void(v1::Segment&)>;
  const std::pair<Damage, const char*> cases[] = {
      {[](auto& s) { s.set_points(0); }, "segment 1: points: must be at least 1"},
      {[](auto& s) { s.mutable_centroid()->set_y(kNan); }, "segment 1: centroid: must be finite"},
      {[](auto& s) { s.clear_box(); }, "box.axes: has 0 axes, but must have 3"},
      {[](auto& s) { s.mutable_box()->add_axes()->set_x(1); }, "box.axes: has 4 axes, but must have 3"},
      {[](auto& s) { s.mutable_box()->mutable_center()->set_z(kInfinity); }, "box.center"},
      {[](auto& s) { s.mutable_box()->mutable_axes(0)->set_y(-1); }, "box.axes"},  // The axes are left-handed then.
      {[](auto& s) { s.mutable_box()->mutable_axes(1)->set_x(0.61); }, "box.axes"},
      {[](auto& s) { s.mutable_box()->mutable_axes(2)->set_x(kNan); }, "box.axes"},
      {[](auto& s) { s.mutable_box()->mutable_half_extents()->set_x(-1e-9); }, "box.half_extents"},
      {[](auto& s) { s.mutable_box()->mutable_half_extents()->set_z(kInfinity); }, "box.half_extents"},
      {[](auto& s) { s.mutable_color()->set_green(255.5); }, "color"},
      {[](auto& s) { s.mutable_color()->set_red(kNan); }, "color"},
      {[](auto& s) { s.mutable_normal()->set_x(0.1); }, "normal"},
      {[](auto& s) { s.mutable_normal()->Clear(); }, "normal"},
  };
  for (const auto& [damage, field] : cases) {
    SegmentMessages messages = to_message(small_statistics());
    damage(*messages.Mutable(0));
    EXPECT_THAT(refusal(messages), testing::HasSubstr(field));
  }
  SegmentMessages messages = to_message(small_statistics());
  messages.SwapElements(0, 1);
  EXPECT_THAT(refusal(messages), testing::HasSubstr("segment 2: points: is 4, more than in the segment before"));
}

}  // namespace
}  // namespace segserve::wire
