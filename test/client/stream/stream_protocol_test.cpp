// SPDX-License-Identifier: Apache-2.0
// One connection: which messages the client sends, and which messages of a server break the protocol.
#include "client/stream/stream_protocol.hpp"

#include <string>
#include <vector>

#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "proto/wire/byte_run.hpp"
#include "test/client/client_scenes.hpp"
#include "test/client/stream/received_message.hpp"

namespace segserve::client {
namespace {

using Request = v1::SegmentStreamRequest;
using Response = v1::SegmentStreamResponse;
using Event = StreamProtocol::Event;

class StreamProtocolTest : public testing::Test {
 protected:
  void SetUp() override {
    OutgoingMessage outgoing;
    ASSERT_TRUE(protocol_.next(outgoing));
    ASSERT_TRUE(outgoing.message.has_open());
    Response opened;
    opened.mutable_opened()->mutable_credit()->set_frames(2);
    opened.mutable_opened()->mutable_credit()->set_bytes(10'000);
    opened.mutable_opened()->set_max_chunk_bytes(150);
    ASSERT_TRUE(protocol_.receive(opened).ok());
  }

  std::vector<Request> sent() {
    std::vector<Request> messages;
    for (OutgoingMessage outgoing; protocol_.next(outgoing);) messages.push_back(received(outgoing));
    return messages;
  }

  static Response outcome(std::uint64_t number, std::size_t label_bytes) {
    Response response;
    v1::FrameOutcome& outcome = *response.mutable_outcome();
    outcome.set_sequence(number);
    outcome.set_kind(v1::OUTCOME_KIND_RESULT);
    outcome.mutable_result()->mutable_labels()->mutable_data()->set_encoded_bytes(label_bytes);
    outcome.set_encoded_bytes(label_bytes);
    outcome.set_crc32(wire::crc32(0, std::string(label_bytes, 'L')));
    return response;
  }
  static Response chunk(std::uint64_t number, std::size_t bytes) {
    Response response;
    response.mutable_chunk()->set_sequence(number);
    response.mutable_chunk()->set_data(std::string(bytes, 'L'));
    return response;
  }

  bool is_refused(Response response) {
    const auto event = protocol_.receive(response);
    return absl::IsInternal(event.status());
  }

  Payload payload_ = *cloud_payload(flat_cloud(10, 10));  // x, y, z and colors: 400 + 400 + 400 + 300 bytes
  StreamProtocol protocol_{v1::StreamOpen()};
};

TEST_F(StreamProtocolTest, CutsAPayloadIntoChunksThatFitItsChecksum) {
  protocol_.begin(7, {}, payload_);
  const auto messages = sent();
  ASSERT_GT(messages.size(), 10U);
  const v1::FrameHeader& header = messages[0].frame();
  EXPECT_EQ(header.sequence(), 1U);  // the number on the wire, not the sequence
  std::string bytes;
  for (std::size_t i = 1; i < messages.size(); ++i) {
    EXPECT_LE(messages[i].chunk().data().size(), 150U);
    bytes += messages[i].chunk().data();
  }
  EXPECT_EQ(bytes.size(), header.encoded_bytes());
  EXPECT_EQ(wire::crc32(0, bytes), header.crc32());
}

TEST_F(StreamProtocolTest, OneUploadAfterTheOther) {
  EXPECT_TRUE(protocol_.has_turn());
  protocol_.begin(1, {}, payload_);
  EXPECT_FALSE(protocol_.has_turn());
  sent();
  EXPECT_TRUE(protocol_.has_turn());
  protocol_.begin(2, {}, payload_);
  sent();
  EXPECT_FALSE(protocol_.has_turn());  // the credit is for two frames
}

TEST_F(StreamProtocolTest, CreditInBytesIsBackAfterTheLastByteOfTheAnswer) {
  EXPECT_EQ(protocol_.fit(10'001), StreamProtocol::Fit::kNever);
  protocol_.begin(1, {}, payload_);
  EXPECT_EQ(protocol_.fit(9000), StreamProtocol::Fit::kLater);
  sent();
  Response response = outcome(1, 20);
  ASSERT_TRUE(protocol_.receive(response).ok());
  EXPECT_EQ(protocol_.fit(9000), StreamProtocol::Fit::kLater);
  response = chunk(1, 20);
  const auto event = protocol_.receive(response);
  ASSERT_TRUE(event.ok()) << event.status();
  EXPECT_EQ(event->kind, Event::kOutcome);
  EXPECT_TRUE(event->intact);
  EXPECT_EQ(event->outcome.result().labels().data().data(), std::string(20, 'L'));
  EXPECT_EQ(protocol_.fit(9000), StreamProtocol::Fit::kNow);
}

TEST_F(StreamProtocolTest, ADamagedAnswerIsNoticed) {
  protocol_.begin(1, {}, payload_);
  sent();
  Response response = outcome(1, 20);
  response.mutable_outcome()->set_crc32(response.outcome().crc32() + 1);
  ASSERT_TRUE(protocol_.receive(response).ok());
  response = chunk(1, 20);
  const auto event = protocol_.receive(response);
  ASSERT_TRUE(event.ok());
  EXPECT_FALSE(event->intact);
}

TEST_F(StreamProtocolTest, NoChunksFollowACancelOrAnOutcome) {
  protocol_.begin(1, {}, payload_);
  OutgoingMessage outgoing;
  ASSERT_TRUE(protocol_.next(outgoing) && protocol_.next(outgoing));
  protocol_.cancel(1);
  auto messages = sent();
  ASSERT_EQ(messages.size(), 1U);
  EXPECT_TRUE(messages[0].has_cancel());

  protocol_.begin(2, {}, payload_);
  ASSERT_TRUE(protocol_.next(outgoing) && protocol_.next(outgoing));
  Response failed = outcome(2, 0);
  failed.mutable_outcome()->set_kind(v1::OUTCOME_KIND_FAILED);
  ASSERT_TRUE(protocol_.receive(failed).ok());
  EXPECT_TRUE(sent().empty());
}

TEST_F(StreamProtocolTest, EndsWhenTheUploadIsThrough) {
  protocol_.begin(1, {}, payload_);
  protocol_.end();
  EXPECT_FALSE(protocol_.has_turn());
  EXPECT_FALSE(protocol_.wants_half_close());
  sent();
  EXPECT_TRUE(protocol_.wants_half_close());
}

TEST_F(StreamProtocolTest, AServerMustKeepToTheProtocol) {
  protocol_.begin(1, {}, payload_);
  sent();
  EXPECT_TRUE(is_refused(outcome(2, 0)));  // there is no such frame
  EXPECT_TRUE(is_refused(chunk(1, 1)));    // there is no result
  Response twice;
  twice.mutable_opened()->mutable_credit()->set_frames(1);
  EXPECT_TRUE(is_refused(twice));
  Response lying = outcome(1, 20);
  lying.mutable_outcome()->set_encoded_bytes(21);
  EXPECT_TRUE(is_refused(lying));
  Response monstrous = outcome(1, 0);
  monstrous.mutable_outcome()->mutable_result()->mutable_labels()->mutable_data()->set_encoded_bytes(~0ULL);
  monstrous.mutable_outcome()->set_encoded_bytes(~0ULL);
  EXPECT_TRUE(is_refused(monstrous));

  constexpr std::size_t kMost = 100 * 28 + (64 << 10U);  // for 100 points
  EXPECT_TRUE(is_refused(outcome(1, kMost + 1)));
  Response long_but_possible = outcome(1, kMost);
  EXPECT_TRUE(StreamProtocol(protocol_).receive(long_but_possible).ok());

  Response begun = outcome(1, 20);
  ASSERT_TRUE(protocol_.receive(begun).ok());
  EXPECT_TRUE(is_refused(chunk(1, 21)));    // it is too long
  EXPECT_TRUE(is_refused(chunk(2, 5)));     // it belongs to another frame
  EXPECT_TRUE(is_refused(outcome(1, 20)));  // it interrupts a result
}

TEST(StreamProtocol, NothingComesBeforeOpened) {
  StreamProtocol protocol{v1::StreamOpen()};
  Response draining;
  draining.mutable_draining();
  EXPECT_TRUE(absl::IsInternal(protocol.receive(draining).status()));
  Response no_credit;
  no_credit.mutable_opened();
  EXPECT_TRUE(absl::IsInternal(protocol.receive(no_credit).status()));
}

}  // namespace
}  // namespace segserve::client
