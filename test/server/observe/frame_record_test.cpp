// SPDX-License-Identifier: Apache-2.0
// Tests that every frame of a stream has exactly one record, and what is in it. Clock and workers are in the test's
// hands.
#include "server/observe/frame_record.hpp"

#include "gmock/gmock.h"
#include "proto/wire/status_message.hpp"
#include "test/server/support/record_keeper.hpp"
#include "test/server/support/session_harness.hpp"

namespace segserve::server {
namespace {

using namespace std::chrono_literals;
using testing::ElementsAre;
using testing::Field;
using testing::SizeIs;

TEST(StatusFacts, TellsWhatTheClientSees) {
  const StatusFacts facts = facts_of(wire::limit_exceeded("the cloud has", 7, "points", "max_points", 5));
  EXPECT_EQ(facts.code, absl::StatusCode::kInvalidArgument);
  EXPECT_EQ(facts.reason, wire::ErrorReason::kLimitExceeded);
  EXPECT_EQ(facts.limit, "max_points");
  EXPECT_EQ(facts.message, "the cloud has 7 points, more than max_points = 5");
  EXPECT_EQ(facts_of(absl::UnknownError("?")).code, absl::StatusCode::kInternal) << "the API has no such code";
  EXPECT_EQ(facts_of(absl::UnavailableError("no")).reason, wire::ErrorReason::kDraining) << "implied by the code";
  EXPECT_EQ(facts_of(absl::OkStatus()).code, absl::StatusCode::kOk);
}

TEST(FrameRecord, OfAResultHasAllNumbersAndTimesInOrder) {
  SessionHarness harness;
  v1::StreamOpen open;
  open.set_client_name("robot");
  harness.open(open);
  SentFrame sent(7);
  sent.header.set_request_id("scan 7");
  sent.header.set_traceparent("00-0af7651916cd43dd8448eb211c80319c-b7ad6b7169203331-01");
  const auto arrival = harness.now;
  harness.say_header(sent.header);
  harness.now += 10ms;
  harness.say_chunk(7, sent.bytes.next());
  while (!sent.bytes.done()) harness.say_chunk(7, sent.bytes.next());
  harness.now += 10ms;
  harness.compute();
  EXPECT_THAT(harness.records->frames(), SizeIs(0)) << "the result is not sent yet";
  harness.now += 10ms;
  std::uint64_t sent_bytes = 0;
  for (const auto& response : harness.read()) sent_bytes += response.ByteSizeLong();

  ASSERT_THAT(harness.records->frames(), SizeIs(1));
  const FrameRecord record = harness.records->frames()[0];
  EXPECT_EQ(record.call, FrameRecord::Call::kStream);
  EXPECT_EQ(record.caller->client_name, "robot");
  EXPECT_EQ(record.caller->peer, "me");
  EXPECT_EQ(record.request_id, "scan 7");
  EXPECT_EQ(record.traceparent, "00-0af7651916cd43dd8448eb211c80319c-b7ad6b7169203331-01");
  EXPECT_EQ(record.sequence, 7U);
  EXPECT_EQ(record.payload_kind, v1::PAYLOAD_KIND_PLANAR);
  EXPECT_GT(record.received_bytes, sent.header.ByteSizeLong() + sent.header.encoded_bytes());
  EXPECT_LT(record.received_bytes, sent.header.ByteSizeLong() + sent.header.encoded_bytes() + 100);
  EXPECT_EQ(record.sent_bytes, sent_bytes);
  EXPECT_EQ(record.outcome, v1::OUTCOME_KIND_RESULT);
  EXPECT_EQ(record.status.code, absl::StatusCode::kOk);
  EXPECT_EQ(record.work.points, 9U);
  EXPECT_EQ(record.work.decoded_bytes, 9U * 16U);
  EXPECT_EQ(record.arrival, arrival);
  EXPECT_EQ(record.uploaded, arrival + 10ms);
  EXPECT_EQ(record.queued, arrival + 10ms);
  EXPECT_EQ(record.decided, arrival + 20ms);
  EXPECT_EQ(record.delivered, arrival + 30ms);
  EXPECT_LE(record.work.started, record.work.decoded);
  EXPECT_LE(record.work.decoded, record.work.segmented);
  EXPECT_LE(record.work.segmented, record.work.encoded);
}

TEST(FrameRecord, OfAFrameThatIsRefusedAtItsHeaderSaysWhy) {
  SessionHarness harness;
  harness.open();
  v1::FrameHeader header = SentFrame(1).header;
  header.set_points(1'000'000);
  harness.say_header(header);
  harness.say_chunk(1, "bytes on their way");
  harness.outcome();
  ASSERT_THAT(harness.records->frames(), SizeIs(1));
  const FrameRecord record = harness.records->frames()[0];
  EXPECT_EQ(record.outcome, v1::OUTCOME_KIND_FAILED);
  EXPECT_EQ(record.status.reason, wire::ErrorReason::kLimitExceeded);
  EXPECT_EQ(record.status.limit, "max_points");
  EXPECT_FALSE(record.uploaded);
  EXPECT_FALSE(record.work.started);
}

TEST(FrameRecord, OfAFrameWithoutMemoryNamesTheMemory) {
  SessionHarness harness;
  harness.open();
  auto lease = harness.ledger.lease(MemoryOwner{"there", "other"}, SessionHarness::kMemory / 2);
  ASSERT_TRUE(lease && lease->resize(SessionHarness::kMemory));
  harness.send(SentFrame(1));
  harness.outcome();
  ASSERT_THAT(harness.records->frames(), SizeIs(1));
  EXPECT_EQ(harness.records->frames()[0].status.reason, wire::ErrorReason::kQueueFull);
  EXPECT_EQ(harness.records->frames()[0].status.limit, "memory_bytes");
}

TEST(FrameRecord, ComesOnceForEveryFrameOfAStreamThatBreaks) {
  SessionHarness harness({.frames = 8, .bytes = 1 << 20});
  harness.open();
  harness.send(SentFrame(1));  // computed, and its result waits to be sent
  harness.compute();
  harness.send(SentFrame(2));  // computed while the stream breaks
  harness.send(SentFrame(3));  // waits for a worker
  harness.send(SentFrame(4));  // cancelled, but its outcome waits for those of 2 and 3
  harness.say_cancel(4);
  harness.say_header(SentFrame(5).header);  // being uploaded
  harness.on_segment = [&](const CloudView&, const Options&, const StopToken& stop) -> absl::StatusOr<Segmentation> {
    harness.session->on_cancel(absl::CancelledError("the connection broke"));
    EXPECT_THAT(harness.records->frames(), SizeIs(4)) << "a worker still has frame 2";
    return stop.check();
  };
  harness.compute();

  EXPECT_THAT(harness.read(), SizeIs(0));
  EXPECT_THAT(harness.records->frames(),
              ElementsAre(Field(&FrameRecord::sequence, 1U), Field(&FrameRecord::sequence, 3U),
                          Field(&FrameRecord::sequence, 4U), Field(&FrameRecord::sequence, 5U),
                          Field(&FrameRecord::sequence, 2U)));
  for (const FrameRecord& record : harness.records->frames()) {
    EXPECT_EQ(record.outcome, v1::OUTCOME_KIND_CANCELLED);
    EXPECT_EQ(record.status.message, "the connection broke");
    EXPECT_FALSE(record.delivered);
    EXPECT_GE(record.decided, record.arrival);
  }
}

TEST(FrameRecord, OfAFrameWhoseClientVanishesDuringTheUploadIsCancelled) {
  SessionHarness harness;
  harness.open();
  harness.say_header(SentFrame(1).header);
  harness.session->on_half_close();
  harness.session->on_tick();
  harness.session->on_cancel(absl::CancelledError("gone"));
  ASSERT_THAT(harness.records->frames(), SizeIs(1));
  EXPECT_EQ(harness.records->frames()[0].outcome, v1::OUTCOME_KIND_CANCELLED);
}

TEST(FrameRecord, OfAFrameInAStreamThatBreaksTheRulesHasTheFaultOfTheStream) {
  SessionHarness harness;
  harness.open();
  harness.send(SentFrame(2));
  harness.send(SentFrame(1));
  ASSERT_THAT(harness.records->frames(), SizeIs(1));
  EXPECT_EQ(harness.records->frames()[0].sequence, 2U);
  EXPECT_EQ(harness.records->frames()[0].outcome, v1::OUTCOME_KIND_FAILED);
  EXPECT_EQ(harness.records->frames()[0].status.reason, wire::ErrorReason::kProtocolViolation);

  const StreamRecord stream = harness.session->record(*harness.session->ended());
  EXPECT_TRUE(stream.is_opened);
  EXPECT_EQ(stream.frames, 1U);
  EXPECT_EQ(stream.status.reason, wire::ErrorReason::kProtocolViolation);
}

TEST(FrameRecord, OfDroppedAndExpiredFramesHasNoFault) {
  SessionHarness harness;
  harness.executor.capacity = 1;
  harness.open(opening(v1::WHEN_BEHIND_DROP_OLDEST));
  harness.send(SentFrame(1));
  SentFrame second(2);
  second.header.mutable_time_to_live()->set_seconds(1);
  harness.send(second);
  harness.now += 2s;
  harness.session->on_tick();
  harness.read();
  EXPECT_THAT(harness.records->frames(), ElementsAre(Field(&FrameRecord::outcome, v1::OUTCOME_KIND_DROPPED),
                                                     Field(&FrameRecord::outcome, v1::OUTCOME_KIND_EXPIRED)));
  for (const FrameRecord& record : harness.records->frames()) EXPECT_EQ(record.status.code, absl::StatusCode::kOk);
}

/// Throws at everything.
class BrokenObserver final : public ServiceObserver {
 public:
  void on_frame(const FrameRecord& /*frame*/) override { throw std::bad_alloc(); }
  void on_stream(const StreamRecord& /*stream*/) override { throw std::bad_alloc(); }
  void on_refused_question(const RefusedQuestion& /*question*/) override { throw std::bad_alloc(); }
};

TEST(ServiceObservers, GoOnWhenOneOfThemThrows) {
  const auto records = std::make_shared<RecordKeeper>();
  const ServiceObservers observers({std::make_shared<BrokenObserver>(), records});
  observers.on_frame({});
  observers.on_stream({});
  observers.on_refused_question({});
  EXPECT_THAT(records->frames(), SizeIs(1));
  EXPECT_THAT(records->streams(), SizeIs(1));
  EXPECT_THAT(records->refused_questions(), SizeIs(1));
}

}  // namespace
}  // namespace segserve::server
