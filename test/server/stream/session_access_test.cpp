// SPDX-License-Identifier: Apache-2.0
// Tests a stream of a subject that has limits, and whose token may be withdrawn. Clock and workers are in the test's
// hands.
#include <filesystem>
#include <fstream>
#include <string>

#include "credentials/token_hash.hpp"
#include "gtest/gtest.h"
#include "server/access/access_control.hpp"
#include "test/server/support/session_harness.hpp"

namespace segserve::server {
namespace {

using namespace std::chrono_literals;

class SubjectSession : public testing::Test {
 protected:
  ~SubjectSession() override { std::filesystem::remove(path_); }

  void write(const std::string& limits, const std::string& token = "abc") const {
    std::ofstream(path_) << limits << "\n[[token]]\nsubject = \"me\"\nsha256 = \""
                         << credentials::to_hex(credentials::hash_of(token)) << "\"\n";
  }
  /// Begins a stream of a subject with these limits.
  void begin(const std::string& limits) {
    write(limits);
    control_ = AccessControl::open({.tokens = path_}).value();
    harness_.session = std::make_shared<StreamSession>(
        harness_.settings, MemoryOwner{"here", "me"}, Caller{.peer = "me"}, harness_.executor, [] {},
        control_->admit({.authorizations = {"Bearer abc"}}).value());
  }
  void take_changes() {
    control_->look_for_changes();
    control_->look_for_changes();
  }

  const std::string path_ =
      std::filesystem::path(testing::TempDir()) / testing::UnitTest::GetInstance()->current_test_info()->name();
  std::unique_ptr<AccessControl> control_;
  SessionHarness harness_;
};

TEST_F(SubjectSession, WhoseTokenIsWithdrawnFinishesWhatHasBegun) {
  begin("");
  harness_.open();
  harness_.send(SentFrame(1));
  write("", "another");
  take_changes();
  harness_.send(SentFrame(2));
  const auto said = harness_.read();
  ASSERT_GE(said.size(), 1U);
  EXPECT_EQ(said[0].draining().reason(), v1::DRAIN_REASON_TOKEN)
      << "the client opens another stream, with the token that it has now";
  EXPECT_EQ(harness_.session->ended(), std::nullopt);
  harness_.compute();
  const auto outcomes = harness_.outcomes();
  ASSERT_EQ(outcomes.size(), 2U);
  EXPECT_EQ(outcomes[0].kind(), v1::OUTCOME_KIND_RESULT);
  EXPECT_EQ(reason_of(outcomes[1]), wire::ErrorReason::kTokenInvalid);
  const auto ended = harness_.session->ended();
  ASSERT_TRUE(ended);
  EXPECT_EQ(wire::details_of(*ended).reason, wire::ErrorReason::kTokenInvalid);
}

TEST_F(SubjectSession, WhoseTokenIsWithdrawnEndsWithoutAFrameToo) {
  begin("");
  harness_.open();
  write("", "another");
  take_changes();
  harness_.session->on_tick();
  EXPECT_TRUE(harness_.read().empty()) << "tokens are looked at once a second";
  harness_.now += 1s;
  harness_.session->on_tick();
  ASSERT_EQ(harness_.read().size(), 1U);
  EXPECT_TRUE(absl::IsUnauthenticated(*harness_.session->ended()));
}

TEST_F(SubjectSession, GoesOnWhenOtherTokensChange) {
  begin("");
  harness_.open();
  write("[default]\nframes_per_second = 100");
  take_changes();
  harness_.now += 1s;
  harness_.session->on_tick();
  harness_.send(SentFrame(1));
  harness_.compute();
  EXPECT_EQ(harness_.outcome().kind(), v1::OUTCOME_KIND_RESULT);
}

TEST_F(SubjectSession, FailsAFrameBeyondTheQuotaAndGoesOn) {
  begin("[default]\nframes_per_second = 0.01");
  harness_.open();
  harness_.send(SentFrame(1));
  harness_.send(SentFrame(2));
  harness_.compute();
  const auto outcomes = harness_.outcomes();
  ASSERT_EQ(outcomes.size(), 2U);
  EXPECT_EQ(outcomes[0].kind(), v1::OUTCOME_KIND_RESULT);
  EXPECT_EQ(reason_of(outcomes[1]), wire::ErrorReason::kQuotaExceeded);
  EXPECT_GT(*wire::details_of(wire::from_message(outcomes[1].status())).retry_delay, 90s);
  EXPECT_EQ(harness_.session->ended(), std::nullopt);
}

TEST_F(SubjectSession, DoesNotPayForAFrameThatTheQueueHasNoRoomFor) {
  begin("[default]\nframes_per_second = 0.01");
  harness_.open(opening(v1::WHEN_BEHIND_REJECT));
  harness_.executor.capacity = 0;
  harness_.send(SentFrame(1));
  EXPECT_EQ(reason_of(harness_.outcome()), wire::ErrorReason::kQueueFull);
  harness_.executor.capacity = 1;
  harness_.send(SentFrame(2));
  harness_.compute();
  EXPECT_EQ(harness_.outcome().kind(), v1::OUTCOME_KIND_RESULT);
}

TEST_F(SubjectSession, GetsNoMoreCreditThanItMayHaveInFlight) {
  begin("[default]\nbytes_in_flight = 1000");
  v1::SegmentStreamRequest open;
  open.mutable_open();
  harness_.say(open);
  const auto said = harness_.read();
  ASSERT_EQ(said.size(), 1U);
  EXPECT_EQ(said[0].opened().credit().bytes(), 1000U);
}

TEST_F(SubjectSession, BytesReturnWithTheOutcome) {
  const SentFrame frame(1);
  begin("[default]\nbytes_in_flight = " + std::to_string(frame.header.encoded_bytes()));
  harness_.open();
  for (std::uint64_t sequence = 1; sequence <= 3; ++sequence) {
    harness_.send(SentFrame(sequence));
    harness_.compute();
    EXPECT_EQ(harness_.outcome().kind(), v1::OUTCOME_KIND_RESULT);
  }
}

TEST_F(SubjectSession, LowersPrioritiesToTheHighest) {
  begin("[default]\nhighest_priority = 2");
  harness_.open();
  SentFrame frame(1);
  frame.header.set_priority(9);
  harness_.send(std::move(frame));
  EXPECT_EQ(harness_.executor.first().priority, 2);
}

}  // namespace
}  // namespace segserve::server
