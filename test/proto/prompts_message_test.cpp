// SPDX-License-Identifier: Apache-2.0
#include "proto/wire/prompts_message.hpp"

#include <functional>
#include <limits>
#include <string>
#include <utility>
#include <vector>

#include "gmock/gmock.h"
#include "proto/wire/status_message.hpp"
#include "test/proto/example_messages.hpp"

namespace segserve::wire {
namespace {

PromptedSelection small_selection() {
  return {.include = {{4, 2, 0.25}},
          .exclude = {{1, 3, 0}},
          .selection = {.smallest = {1, 4}, .steps = {{1, 3}, {0, 5}}},
          .candidate = 1,
          .thresholds = {0.25, 0.5},
          .labels = {},
          .statistics = small_statistics()[0]};
}

TEST(WirePrompts, RoundTrip) {
  const Prompts prompts{.include = {Eigen::Vector3d(1, -2, 0.5), Pixel{0, 0}}, .exclude = {Pixel{3, 4}}, .larger = -2};
  std::vector<FieldViolation> faults;
  EXPECT_EQ(from_message(to_message(prompts), faults), prompts);
  EXPECT_TRUE(faults.empty());
}

TEST(WirePrompts, NameEveryFault) {
  v1::Prompts message;
  message.add_include();
  message.add_exclude()->mutable_position()->set_x(std::numeric_limits<double>::quiet_NaN());
  std::vector<FieldViolation> faults;
  from_message(message, faults);
  ASSERT_EQ(faults.size(), 2U);
  EXPECT_EQ(faults[0].field, "prompts.include[0]");
  EXPECT_EQ(faults[1].field, "prompts.exclude[0]");
  for (std::size_t k = 0; k <= kMostPrompts; ++k) message.add_include()->mutable_pixel();
  faults.clear();
  from_message(message, faults);
  EXPECT_THAT(faults, testing::Contains(testing::Field(&FieldViolation::field, "prompts.include")));
}

TEST(WireSelection, RoundTrip) {
  const auto read = from_message(to_message(small_selection()), 5, 4);
  ASSERT_TRUE(read.ok()) << read.status();
  EXPECT_EQ(*read, small_selection());
}

TEST(WireSelection, RefusesWhatNoServerSends) {
  using Damage = std::function<void(v1::Selection&)>;
  const std::pair<Damage, const char*> cases[] = {
      {[](auto& s) { s.mutable_include(0)->set_point(5); }, "selection.include"},
      {[](auto& s) { s.mutable_exclude(0)->set_supervoxel(0); }, "selection.exclude"},
      {[](auto& s) { s.mutable_include(0)->set_distance(-1); }, "selection.include"},
      {[](auto& s) { s.clear_smallest(); }, "selection.smallest"},
      {[](auto& s) { s.set_smallest(0, 7); }, "selection.smallest"},
      {[](auto& s) { s.set_step_nodes(0, 7); }, "selection.step_nodes"},
      {[](auto& s) { s.add_step_groups(0); }, "selection.step_groups"},
      {[](auto& s) { s.set_step_groups(0, 2); }, "selection.step_groups"},
      {[](auto& s) { s.set_candidate(3); }, "selection.candidate"},
      {[](auto& s) { s.mutable_thresholds()->set_upper(0.1); }, "selection.thresholds"},
      {[](auto& s) { s.mutable_segment()->set_points(0); }, "selection.segment: points"},
  };
  for (const auto& [damage, text] : cases) {
    v1::Selection message = to_message(small_selection());
    damage(message);
    const absl::Status status = from_message(message, 5, 4).status();
    EXPECT_EQ(details_of(status).reason, ErrorReason::kMalformedPayload) << text;
    EXPECT_THAT(std::string(status.message()), testing::HasSubstr(text));
  }
}

}  // namespace
}  // namespace segserve::wire
