// SPDX-License-Identifier: Apache-2.0
// StreamOptions::on_outcome gets every outcome. A callback that takes its time delays nothing but later callbacks.
#include <atomic>
#include <chrono>
#include <cstdint>
#include <future>
#include <map>
#include <string>
#include <thread>
#include <vector>

#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "segserve/client/client.hpp"
#include "test/client/client_scenes.hpp"
#include "test/client/fake_server.hpp"

namespace segserve::client {
namespace {

using std::chrono::milliseconds;

class StreamCallbackTest : public testing::Test {
 protected:
  Stream open(StreamOptions options) const {
    options.retry.first_backoff = milliseconds(5);
    const auto client = Client::connect({.address = a_.address() + "," + b_.address()});
    return client->open_stream(std::move(options)).value();
  }

  FakeServer a_, b_;
};

TEST_F(StreamCallbackTest, GetsEveryOutcomeInOrder) {
  std::vector<std::uint64_t> sequences;
  Stream stream = open({.on_outcome = [&](const Outcome& outcome) { sequences.push_back(outcome.sequence); }});
  for (int i = 0; i < 10; ++i) EXPECT_TRUE(stream.send(flat_cloud(20, 20)).ok());
  stream.finish();
  EXPECT_FALSE(stream.next().has_value());
  EXPECT_TRUE(stream.done());
  EXPECT_THAT(sequences, testing::ElementsAre(1, 2, 3, 4, 5, 6, 7, 8, 9, 10));
}

TEST_F(StreamCallbackTest, MaySendTheNextFrame) {
  Stream* stream = nullptr;
  std::vector<OutcomeKind> kinds;
  const auto on_outcome = [&](const Outcome& outcome) {
    kinds.push_back(outcome.kind);
    if (outcome.sequence == 5) return stream->finish();
    EXPECT_TRUE(stream->send(flat_cloud(20, 20)).ok());
  };
  Stream opened = open({.max_in_flight = 1, .on_outcome = on_outcome});
  stream = &opened;
  EXPECT_TRUE(stream->send(flat_cloud(20, 20)).ok());
  EXPECT_FALSE(stream->next().has_value());
  EXPECT_EQ(kinds, std::vector<OutcomeKind>(5, OutcomeKind::kResult));
}

TEST_F(StreamCallbackTest, GetsTheCancelledFramesOfAStreamThatIsDestroyed) {
  a_.answer = b_.answer = [](const auto&) { return FakeServer::kNothing; };
  std::vector<OutcomeKind> kinds;
  {
    Stream stream = open({.on_outcome = [&](const Outcome& outcome) { kinds.push_back(outcome.kind); }});
    for (int i = 0; i < 3; ++i) ASSERT_TRUE(stream.send(flat_cloud(20, 20)).ok());
  }
  EXPECT_EQ(kinds, std::vector<OutcomeKind>(3, OutcomeKind::kCancelled));
}

TEST_F(StreamCallbackTest, DelaysNoDeadlineAndNoExpiryWhileItBlocks) {
  constexpr milliseconds kBlocked(2000), kMost(1500);
  a_.answer = b_.answer = [](const v1::FrameHeader& header) {
    return header.frame_id() == "answered" ? FakeServer::kResult : FakeServer::kNothing;
  };
  std::promise<void> blocked;
  std::map<std::string, Outcome> outcomes;
  const auto on_outcome = [&](const Outcome& outcome) {
    outcomes[outcome.frame_id] = outcome;
    if (outcome.frame_id != "answered") return;
    blocked.set_value();
    std::this_thread::sleep_for(kBlocked);
  };
  {
    Stream stream = open({.order = Order::kDone, .max_in_flight = 1, .max_waiting = 2, .on_outcome = on_outcome});
    ASSERT_TRUE(stream.send(flat_cloud(20, 20), {.frame_id = "answered"}).ok());
    blocked.get_future().wait();
    ASSERT_TRUE(stream.send(flat_cloud(20, 20), {.frame_id = "sent", .timeout = milliseconds(200)}).ok());
    ASSERT_TRUE(stream.send(flat_cloud(20, 20), {.frame_id = "waiting", .time_to_live = milliseconds(100)}).ok());
    stream.finish();
    EXPECT_FALSE(stream.next().has_value());
  }
  EXPECT_TRUE(absl::IsDeadlineExceeded(outcomes["sent"].status)) << outcomes["sent"].status;
  EXPECT_EQ(outcomes["waiting"].kind, OutcomeKind::kExpired) << outcomes["waiting"].status;
  for (const char* name : {"sent", "waiting"}) {
    const FrameReport& report = outcomes[name].report;
    EXPECT_LT(report.outcome_done - report.handed_over, kMost) << name;
  }
}

TEST_F(StreamCallbackTest, HoldsUpNoProbeOfASilentServerWhileItBlocks) {
  std::promise<std::string> first_address;
  std::atomic<int> results = 0;
  std::atomic<bool> moved_while_blocked = false;
  const auto answered = [&] { return a_.answered + b_.answered; };
  const auto on_outcome = [&](const Outcome& outcome) {
    ++results;
    if (outcome.sequence != 1) return;
    first_address.set_value(outcome.report.address);
    const Time give_up = Clock::now() + milliseconds(10'000);
    while (answered() < 2 && Clock::now() < give_up) std::this_thread::sleep_for(milliseconds(5));
    moved_while_blocked = answered() == 2;
  };
  Stream stream = open({.progress_timeout = milliseconds(400), .on_outcome = on_outcome});
  ASSERT_TRUE(stream.send(flat_cloud(20, 20)).ok());
  FakeServer& used = first_address.get_future().get() == a_.address() ? a_ : b_;
  used.go_silent();
  ASSERT_TRUE(stream.send(flat_cloud(20, 20)).ok());
  stream.finish();
  EXPECT_FALSE(stream.next().has_value());
  EXPECT_TRUE(moved_while_blocked);
  EXPECT_EQ(results, 2);
  used.stop();
}

}  // namespace
}  // namespace segserve::client
