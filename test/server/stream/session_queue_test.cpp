// SPDX-License-Identifier: Apache-2.0
// Tests frames that wait for a worker: cancels, times to live, and frames that make way for others. Clock and workers
// are in the test's hands.
#include <thread>

#include "gmock/gmock.h"
#include "test/server/support/session_harness.hpp"

namespace segserve::server {
namespace {

using namespace std::chrono_literals;
using testing::ElementsAre;
using v1::FrameOutcome;

TEST(Session, CancelTakesAFrameOutWhereverItIs) {
  SessionHarness harness;
  harness.open(opening(v1::WHEN_BEHIND_BLOCK, v1::RESULT_ORDER_UNORDERED));
  harness.say_cancel(99);  // there is no such frame
  EXPECT_TRUE(harness.read().empty());

  SentFrame uploading(1);
  harness.say_header(uploading.header);
  harness.say_cancel(1);
  EXPECT_EQ(harness.outcome().kind(), v1::OUTCOME_KIND_CANCELLED);

  harness.send(SentFrame(2));
  harness.say_cancel(2);
  EXPECT_EQ(harness.outcome().kind(), v1::OUTCOME_KIND_CANCELLED);
  EXPECT_EQ(harness.executor.queued(), 0U);

  harness.send(SentFrame(3));
  harness.on_segment = [&](const CloudView&, const Options&, const StopToken& stop) -> absl::StatusOr<Segmentation> {
    EXPECT_FALSE(stop.stopped());
    harness.say_cancel(3);
    EXPECT_TRUE(stop.stopped());
    return stop.check();
  };
  harness.compute();
  EXPECT_EQ(harness.outcome().kind(), v1::OUTCOME_KIND_CANCELLED);
  harness.say_cancel(3);  // its outcome is known already
  EXPECT_TRUE(harness.read().empty());
}

TEST(Session, FramesExpireWithTheirAgeAtTheClientCounted) {
  SessionHarness harness;
  harness.open(opening(v1::WHEN_BEHIND_BLOCK, v1::RESULT_ORDER_UNORDERED));
  const auto frame = [](std::uint64_t sequence) {
    SentFrame made(sequence);
    made.header.mutable_time_to_live()->set_seconds(1);
    made.header.mutable_age()->set_nanos(400'000'000);
    return made;
  };
  harness.send(frame(1));
  harness.say_header(frame(2).header);
  harness.now += 599ms;
  harness.session->on_tick();
  EXPECT_TRUE(harness.read().empty());
  harness.now += 1ms;
  harness.session->on_tick();
  for (const FrameOutcome& outcome : harness.outcomes()) EXPECT_EQ(outcome.kind(), v1::OUTCOME_KIND_EXPIRED);
  EXPECT_EQ(harness.executor.queued(), 0U) << "nobody computes what nobody wants";
  EXPECT_EQ(harness.session->frames_in_flight(), 0U);

  harness.send(frame(3));
  harness.on_segment = [&](const CloudView& cloud, const auto&, const auto&) {
    harness.now += 1s;
    return SessionHarness::all_in_one(cloud);
  };
  harness.compute();
  EXPECT_EQ(harness.outcome().kind(), v1::OUTCOME_KIND_EXPIRED) << "too late is too late";
}

TEST(Session, AFrameThatCannotBeDoneInTimeIsNotBegun) {
  SessionHarness harness;
  harness.open(opening(v1::WHEN_BEHIND_BLOCK, v1::RESULT_ORDER_UNORDERED));
  harness.executor.time_of_a_frame = 300ms;
  for (const std::uint64_t sequence : {1, 2}) {
    SentFrame frame(sequence);
    frame.header.mutable_time_to_live()->set_seconds(1);
    harness.send(std::move(frame));
  }
  int segmented = 0;
  harness.on_segment = [&](const CloudView& cloud, const auto&, const auto&) {
    ++segmented;
    return SessionHarness::all_in_one(cloud);
  };
  harness.now += 700ms;
  harness.compute();
  EXPECT_EQ(harness.outcome().kind(), v1::OUTCOME_KIND_RESULT);
  harness.now += 1ms;
  harness.compute();
  EXPECT_EQ(harness.outcome().kind(), v1::OUTCOME_KIND_EXPIRED);
  EXPECT_EQ(segmented, 1);
}

TEST(Session, DropOldestMakesRoomForTheNewest) {
  SessionHarness harness;
  harness.executor.capacity = 2;
  harness.open(opening(v1::WHEN_BEHIND_DROP_OLDEST));
  for (const std::uint64_t sequence : {1, 2, 3}) harness.send(SentFrame(sequence));
  FrameOutcome outcome = harness.outcome();
  EXPECT_EQ(outcome.sequence(), 1U);
  EXPECT_EQ(outcome.kind(), v1::OUTCOME_KIND_DROPPED);
  harness.compute();
  harness.compute();
  EXPECT_THAT(sequences(harness.outcomes()), ElementsAre(2U, 3U));

  harness.executor.capacity = 0;  // other streams fill the queue
  harness.send(SentFrame(4));
  outcome = harness.outcome();
  EXPECT_EQ(outcome.sequence(), 4U);
  EXPECT_EQ(outcome.kind(), v1::OUTCOME_KIND_DROPPED);
}

TEST(Session, RejectRefusesTheNewestAndBlockLosesNothing) {
  SessionHarness harness;
  harness.executor.capacity = 1;
  harness.open(opening(v1::WHEN_BEHIND_REJECT));
  harness.send(SentFrame(1));
  harness.send(SentFrame(2));
  harness.compute();
  const auto outcomes = harness.outcomes();
  ASSERT_EQ(outcomes.size(), 2U);
  EXPECT_EQ(outcomes[0].kind(), v1::OUTCOME_KIND_RESULT);
  EXPECT_EQ(outcomes[1].kind(), v1::OUTCOME_KIND_FAILED);
  EXPECT_EQ(reason_of(outcomes[1]), wire::ErrorReason::kQueueFull);

  SessionHarness patient;
  patient.executor.capacity = 1;
  patient.open(opening(v1::WHEN_BEHIND_BLOCK));
  for (const std::uint64_t sequence : {1, 2, 3}) patient.send(SentFrame(sequence));
  while (patient.executor.queued() > 0) patient.compute();
  EXPECT_THAT(sequences(patient.outcomes()), ElementsAre(1U, 2U, 3U));
}

TEST(Session, TheExecutorLearnsPriorityPointsAndBytes) {
  SessionHarness harness;
  harness.open();
  SentFrame frame(1);
  frame.header.set_priority(-3);
  harness.send(frame);
  EXPECT_EQ(harness.executor.first().priority, -3);
  EXPECT_EQ(harness.executor.first().points, 9U);
  EXPECT_EQ(harness.executor.first().bytes, frame.header.encoded_bytes());
}

TEST(Session, AnUploadThatStallsFails) {
  SessionHarness harness;
  harness.open();
  SentFrame frame(1);
  harness.say_header(frame.header);
  harness.now += 4s;
  harness.say_chunk(1, frame.bytes.next(1));
  harness.now += 4s;
  harness.session->on_tick();
  EXPECT_TRUE(harness.read().empty()) << "a slow one does not";
  harness.now += 1s;
  harness.session->on_tick();
  EXPECT_EQ(reason_of(harness.outcome()), wire::ErrorReason::kUploadStalled);
  harness.say_chunk(1, frame.bytes.next(1));  // the chunk was on its way
  harness.send(SentFrame(2));
  harness.compute();
  EXPECT_EQ(harness.outcome().kind(), v1::OUTCOME_KIND_RESULT);
}

// Frames are sent, cancelled and computed on several threads at once, also under ThreadSanitizer. Every frame must have
// exactly one outcome.
TEST(Session, EveryFrameHasExactlyOneOutcome) {
  SessionHarness harness({.frames = 8, .bytes = 1 << 20});
  harness.open(opening(v1::WHEN_BEHIND_DROP_OLDEST, v1::RESULT_ORDER_UNORDERED));
  constexpr std::uint64_t kFrames = 400;
  std::mutex mutex;
  std::vector<FrameJob> stolen;
  std::atomic<bool> done{false};
  const auto work = [&] {
    while (!done) {
      FrameJob job;
      {
        const std::lock_guard lock(mutex);
        if (stolen.empty()) continue;
        job = std::move(stolen.back());
        stolen.pop_back();
      }
      job.run(harness.backend());
    }
  };
  std::thread one(work), two(work);
  std::map<std::uint64_t, int> outcomes;
  const auto pump = [&] {
    for (const FrameOutcome& outcome : harness.outcomes()) ++outcomes[outcome.sequence()];
    while (harness.executor.queued() > 2) {
      const std::lock_guard lock(mutex);
      stolen.push_back(harness.executor.take());
    }
  };
  for (std::uint64_t sequence = 0; sequence < kFrames; ++sequence) {
    while (sequence >= outcomes.size() + 8) pump();
    harness.send(SentFrame(sequence));
    if (sequence % 3 == 0) harness.say_cancel(sequence - sequence % 2);
    harness.session->on_tick();
  }
  while (harness.executor.queued() > 0) {
    const std::lock_guard lock(mutex);
    stolen.push_back(harness.executor.take());
  }
  while (outcomes.size() < kFrames) pump();
  done = true;
  one.join();
  two.join();
  pump();
  for (const auto& [sequence, count] : outcomes) EXPECT_EQ(count, 1) << sequence;
  EXPECT_FALSE(harness.session->ended());
}

}  // namespace
}  // namespace segserve::server
