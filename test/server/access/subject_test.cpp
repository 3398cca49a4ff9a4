// SPDX-License-Identifier: Apache-2.0
#include "server/access/subject.hpp"

#include <memory>
#include <utility>
#include <vector>

#include "gtest/gtest.h"
#include "proto/wire/status_message.hpp"

namespace segserve::server {
namespace {

using namespace std::chrono_literals;

const Subject::Time kStart{1000s};

std::shared_ptr<Subject> make_subject(const credentials::SubjectLimits& limits) {
  return std::make_shared<Subject>("robot-7", limits, kStart);
}

wire::ErrorDetails refusal(const std::shared_ptr<Subject>& subject, std::uint64_t points, std::uint64_t bytes,
                           Subject::Time now = kStart) {
  const auto lease = subject->admit(points, bytes, now);
  EXPECT_TRUE(absl::IsResourceExhausted(lease.status())) << lease.status();
  return wire::details_of(lease.status());
}

TEST(Subject, WithoutLimitsTakesEverything) {
  const auto free = make_subject({});
  for (int i = 0; i < 1000; ++i) EXPECT_TRUE(free->admit(1'000'000'000, 1'000'000'000, kStart).ok());
}

TEST(Subject, ToldOfAQuotaLearnsWhichAndWhenToComeAgain) {
  const auto slow = make_subject({.frames_per_second = 2});
  EXPECT_TRUE(slow->admit(1, 1, kStart).ok());
  EXPECT_TRUE(slow->admit(1, 1, kStart).ok());
  const wire::ErrorDetails details = refusal(slow, 1, 1);
  EXPECT_EQ(refusal(slow, 1, 1).retry_delay, 1000ms) << "it is the second in line";
  EXPECT_EQ(details.reason, wire::ErrorReason::kQuotaExceeded);
  EXPECT_EQ(details.metadata.at("limit"), "frames_per_second");
  EXPECT_EQ(details.metadata.at("allowed"), "2");
  EXPECT_EQ(details.retry_delay, 500ms);
  ASSERT_EQ(details.quotas.size(), 1U);
  EXPECT_EQ(details.quotas[0].subject, "subject:robot-7");
  EXPECT_EQ(details.quotas[0].description, "frames_per_second is 2");
  EXPECT_TRUE(slow->admit(1, 1, kStart + 500ms).ok()) << "the delay was true";
}

TEST(Subject, PaysForThePointsThatFramesTurnOutToHave) {
  const auto small = make_subject({.points_per_second = 1000});
  auto lease = small->admit(100, 1, kStart);
  ASSERT_TRUE(lease.ok());
  lease->settle(1500);
  const wire::ErrorDetails details = refusal(small, 500, 1);
  EXPECT_EQ(details.retry_delay, 1000ms);
  EXPECT_EQ(details.metadata.at("limit"), "points_per_second");
  lease->settle(1000);
  EXPECT_EQ(refusal(small, 250, 1).retry_delay, 750ms) << "250 points, behind 500 of another";
}

TEST(Subject, TakesNothingForAFrameThatItRefuses) {
  const auto both = make_subject({.frames_per_second = 2, .points_per_second = 100});
  const auto lease = both->admit(100, 1, kStart);
  for (int i = 0; i < 10; ++i) EXPECT_EQ(refusal(both, 100, 1).metadata.at("limit"), "points_per_second");
  EXPECT_TRUE(both->admit(100, 1, kStart + 1s).ok());
}

TEST(Subject, GetsBackWhatTheServerCouldNotTake) {
  const auto one = make_subject({.frames_per_second = 1, .points_per_second = 100, .bytes_in_flight = 10});
  for (int i = 0; i < 5; ++i) {
    auto lease = one->admit(100, 10, kStart);
    ASSERT_TRUE(lease.ok()) << i;
    lease->refund();
  }
}

TEST(Subject, BytesAreInFlightUntilTheLeaseEnds) {
  const auto narrow = make_subject({.bytes_in_flight = 100});
  std::vector<QuotaLease> leases;
  leases.push_back(*narrow->admit(1, 60, kStart));
  leases.push_back(*narrow->admit(1, 40, kStart));
  const wire::ErrorDetails details = refusal(narrow, 1, 1);
  EXPECT_EQ(details.reason, wire::ErrorReason::kQuotaExceeded);
  EXPECT_EQ(details.metadata.at("limit"), "bytes_in_flight");
  EXPECT_TRUE(details.retry_delay.has_value());
  leases.pop_back();
  leases.push_back(*narrow->admit(1, 40, kStart));
  QuotaLease moved = std::move(leases[0]);
  leases.clear();
  EXPECT_EQ(refusal(narrow, 1, 41).metadata.at("limit"), "bytes_in_flight");
  moved = QuotaLease();
  EXPECT_TRUE(narrow->admit(1, 100, kStart).ok());
}

TEST(Subject, AFrameThatNeverFitsIsNotToldToComeAgain) {
  const wire::ErrorDetails details = refusal(make_subject({.bytes_in_flight = 100}), 1, 101);
  EXPECT_EQ(details.reason, wire::ErrorReason::kLimitExceeded);
  EXPECT_EQ(details.metadata.at("limit"), "bytes_in_flight");
  EXPECT_EQ(details.metadata.at("actual"), "101");
  EXPECT_FALSE(details.retry_delay.has_value());
}

TEST(Subject, TakesNewLimits) {
  const auto changing = make_subject({.frames_per_second = 1});
  EXPECT_TRUE(changing->admit(1, 1, kStart).ok());
  refusal(changing, 1, 1);
  changing->set_limits({.frames_per_second = 100, .highest_priority = 3}, kStart);
  EXPECT_EQ(changing->limits().highest_priority, 3);
  EXPECT_TRUE(changing->admit(1, 1, kStart + 10ms).ok());
  changing->set_limits({}, kStart + 10ms);
  for (int i = 0; i < 1000; ++i) EXPECT_TRUE(changing->admit(1, 1, kStart + 10ms).ok());
}

TEST(Subject, IsAtRestOnceItMayTakeEverythingAgain) {
  const auto busy = make_subject({.frames_per_second = 10});
  EXPECT_TRUE(busy->is_at_rest(kStart));
  {
    const auto lease = busy->admit(1, 1, kStart);
    EXPECT_FALSE(busy->is_at_rest(kStart + 1s)) << "bytes are in flight";
  }
  EXPECT_FALSE(busy->is_at_rest(kStart + 50ms));
  EXPECT_TRUE(busy->is_at_rest(kStart + 100ms));
}

}  // namespace
}  // namespace segserve::server
