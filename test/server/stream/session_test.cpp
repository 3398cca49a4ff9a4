// SPDX-License-Identifier: Apache-2.0
// Tests the protocol of stream.proto without a transport: messages in both directions, credit, and faults. Clock and
// workers are in the test's hands.
#include <functional>
#include <new>
#include <stdexcept>

#include "gmock/gmock.h"
#include "proto/wire/request_message.hpp"
#include "test/server/support/session_harness.hpp"

namespace segserve::server {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using v1::FrameOutcome;

void expect_violation(const SessionHarness& harness, const std::string& text) {
  const auto ended = harness.session->ended();
  ASSERT_TRUE(ended.has_value()) << text;
  EXPECT_EQ(ended->code(), absl::StatusCode::kInvalidArgument);
  EXPECT_EQ(wire::details_of(*ended).reason, wire::ErrorReason::kProtocolViolation);
  EXPECT_THAT(std::string(ended->message()), HasSubstr(text));
}

TEST(Session, OpensWithItsCreditAndTheServersLimits) {
  SessionHarness harness({.frames = 3, .bytes = 5000});
  harness.settings.greeting.set_server_version("1.2.3");
  v1::SegmentStreamRequest message;
  message.mutable_open()->mutable_wanted()->set_bytes(4000);
  harness.say(message);
  const auto said = harness.read();
  ASSERT_EQ(said.size(), 1U);
  EXPECT_EQ(said[0].opened().server_version(), "1.2.3");
  EXPECT_EQ(said[0].opened().credit().frames(), 3U);
  EXPECT_EQ(said[0].opened().credit().bytes(), 4000U);
  EXPECT_FALSE(harness.session->ended());
}

TEST(Session, AFrameGetsItsResult) {
  SessionHarness harness;
  harness.open();
  SentFrame frame(7);
  frame.header.set_request_id("a");
  frame.header.set_frame_id("camera");
  frame.header.mutable_stamp()->set_seconds(12);
  harness.send(frame, 10);
  EXPECT_TRUE(harness.read().empty()) << "nothing is known before it is computed";
  const int wakes = harness.wakes;
  harness.compute();
  EXPECT_GT(harness.wakes, wakes) << "the transport would not ask";

  const auto said = harness.read();
  ASSERT_EQ(said.size(), 2U);
  FrameOutcome outcome = said[0].outcome();
  EXPECT_EQ(outcome.sequence(), 7U);
  EXPECT_EQ(outcome.request_id(), "a");
  EXPECT_EQ(outcome.frame_id(), "camera");
  EXPECT_EQ(outcome.stamp().seconds(), 12);
  EXPECT_EQ(outcome.kind(), v1::OUTCOME_KIND_RESULT);
  EXPECT_FALSE(outcome.has_status());

  wire::IncomingBytes bytes(wire::result_block_sizes(outcome.result()));
  EXPECT_EQ(bytes.missing(), outcome.encoded_bytes());
  EXPECT_EQ(said[1].chunk().sequence(), 7U);
  ASSERT_TRUE(bytes.add(said[1].chunk().data()));
  EXPECT_EQ(bytes.missing(), 0U);
  EXPECT_EQ(bytes.crc32(), outcome.crc32());
  bytes.move_to(wire::result_blocks(*outcome.mutable_result()));
  EXPECT_EQ(outcome.result().labels().data().data(), std::string(9, '\1'));
}

TEST(Session, TheSegmenterGetsTheCloudAndTheOptions) {
  SessionHarness harness;
  harness.settings.resolver = FrameResolver(SessionHarness::limited(2));
  v1::StreamOpen open;
  open.mutable_options()->set_voxel_resolution(0.01);
  open.mutable_options()->set_threads(8);
  harness.open(open);
  std::vector<double> resolutions;
  std::vector<std::uint32_t> threads;
  harness.on_segment = [&](const CloudView& cloud, const Options& options, const StopToken&) {
    EXPECT_EQ(cloud.size(), 9U);
    EXPECT_EQ(cloud.z[8], 1.0F);
    resolutions.push_back(resolved(options).voxel_resolution.value());
    threads.push_back(options.threads);
    return SessionHarness::all_in_one(cloud);
  };
  harness.send(SentFrame(1));
  harness.compute();
  SentFrame own(2);
  own.header.mutable_options()->set_voxel_resolution(0.02);
  harness.send(own);
  harness.compute();
  EXPECT_THAT(resolutions, ElementsAre(0.01, 0.02));
  EXPECT_THAT(threads, ElementsAre(2U, 1U)) << "a frame's options replace those of the stream as a whole";
}

TEST(Session, OutcomesComeInTheOrderOfTheFramesIfAskedFor) {
  for (const bool ordered : {true, false}) {
    SessionHarness harness;
    harness.open(opening(v1::WHEN_BEHIND_BLOCK, ordered ? v1::RESULT_ORDER_ORDERED : v1::RESULT_ORDER_UNORDERED));
    harness.send(SentFrame(1));
    harness.send(SentFrame(2));
    FrameJob first = harness.executor.take();
    harness.compute();
    EXPECT_THAT(sequences(harness.outcomes()),
                ordered ? testing::IsEmpty() : testing::Matcher<std::vector<std::uint64_t>>(ElementsAre(2U)));
    first.run(harness.backend());
    EXPECT_THAT(sequences(harness.outcomes()),
                ordered ? testing::Matcher<std::vector<std::uint64_t>>(ElementsAre(1U, 2U)) : ElementsAre(1U));
  }
}

TEST(Session, AFailedFrameDoesNotEndTheStream) {
  SessionHarness harness;
  harness.open();
  SentFrame wrong(1);
  wrong.header.mutable_options()->set_voxel_resolution(-1);
  wrong.header.mutable_cloud()->clear_view();
  harness.send(wrong);  // all its chunks follow, because they were on their way
  const FrameOutcome outcome = harness.outcome();
  EXPECT_EQ(outcome.kind(), v1::OUTCOME_KIND_FAILED);
  const auto fields = wire::details_of(wire::from_message(outcome.status())).fields;
  EXPECT_EQ(fields.size(), 2U) << "every wrong field: " << outcome.status().message();

  SentFrame too_large(2, equal_points(1001, 0, 0, 1));
  harness.say_header(too_large.header);
  EXPECT_EQ(reason_of(harness.outcome()), wire::ErrorReason::kLimitExceeded);

  SentFrame bad_cloud(3);
  harness.send(bad_cloud);
  harness.on_segment = [](const auto&, const auto&, const auto&) { return absl::InvalidArgumentError("z <= 0"); };
  harness.compute();
  EXPECT_EQ(reason_of(harness.outcome()), wire::ErrorReason::kInvalidCloud);

  harness.on_segment = nullptr;
  harness.send(SentFrame(5));
  harness.compute();
  EXPECT_EQ(harness.outcome().kind(), v1::OUTCOME_KIND_RESULT);
  EXPECT_FALSE(harness.session->ended());
}

TEST(Session, AnExceptionFailsItsFrameOnlyAndLeaksNothing) {
  SessionHarness harness;
  harness.open();
  const std::vector<std::function<void()>> throws = {[] { throw std::runtime_error("secret"); },
                                                     [] { throw std::bad_alloc(); }, [] { throw 1; }};
  std::uint64_t sequence = 0;
  for (const auto& throw_it : throws) {
    harness.on_segment = [&](const auto&, const auto&, const auto&) -> absl::StatusOr<Segmentation> {
      throw_it();
      return absl::OkStatus();
    };
    harness.send(SentFrame(++sequence));
    harness.compute();
    const FrameOutcome failed = harness.outcome();
    EXPECT_EQ(failed.kind(), v1::OUTCOME_KIND_FAILED);
    EXPECT_EQ(failed.status().code(), static_cast<int>(absl::StatusCode::kInternal));
    EXPECT_EQ(reason_of(failed), wire::ErrorReason::kInternal);
    EXPECT_THAT(failed.status().message(), testing::Not(HasSubstr("secret")));

    harness.on_segment = nullptr;
    harness.send(SentFrame(++sequence));
    harness.compute();
    EXPECT_EQ(harness.outcome().kind(), v1::OUTCOME_KIND_RESULT) << "the worker and the stream go on";
  }
  EXPECT_FALSE(harness.session->ended());
}

TEST(Session, WhatAHeaderAnnouncesMustHold) {
  SessionHarness harness;
  harness.open();
  SentFrame sum(1);
  sum.header.set_encoded_bytes(sum.header.encoded_bytes() + 1);
  harness.say_header(sum.header);
  FrameOutcome outcome = harness.outcome();
  EXPECT_EQ(reason_of(outcome), wire::ErrorReason::kInvalidField);
  EXPECT_THAT(outcome.status().message(), HasSubstr("encoded_bytes"));

  SentFrame inside(2);
  inside.header.mutable_cloud()->mutable_planar()->mutable_x()->set_data("abc");
  harness.say_header(inside.header);
  EXPECT_THAT(harness.outcome().status().message(), HasSubstr("chunks"));

  SentFrame negative(3);
  negative.header.mutable_age()->set_seconds(-1);
  harness.say_header(negative.header);
  EXPECT_THAT(harness.outcome().status().message(), HasSubstr("age"));

  SentFrame decoded(4);
  decoded.header.set_decoded_bytes(std::uint64_t{1} << 40U);
  harness.say_header(decoded.header);
  EXPECT_EQ(reason_of(harness.outcome()), wire::ErrorReason::kLimitExceeded);
}

TEST(Session, DamagedPayloadIsToBeSentAgain) {
  SessionHarness harness;
  harness.open();
  SentFrame frame(1);
  frame.header.set_crc32(frame.header.crc32() ^ 1U);
  harness.send(frame);
  const FrameOutcome outcome = harness.outcome();
  EXPECT_EQ(outcome.status().code(), static_cast<int>(absl::StatusCode::kAborted));
  EXPECT_EQ(reason_of(outcome), wire::ErrorReason::kChecksum);
  EXPECT_EQ(harness.executor.queued(), 0U);
}

TEST(Session, CreditIsUsedByHeadersAndReturnedWithTheLastChunk) {
  const std::uint64_t bytes = SentFrame(1).header.encoded_bytes();
  SessionHarness harness({.frames = 2, .bytes = 2 * bytes});
  harness.open();
  harness.send(SentFrame(1));
  harness.send(SentFrame(2));
  harness.compute();
  v1::SegmentStreamResponse message;
  ASSERT_TRUE(harness.session->next(message));  // this is the outcome; its chunk follows
  harness.read();
  harness.send(SentFrame(3));  // the credit allows a frame again
  EXPECT_FALSE(harness.session->ended());
  harness.say_header(SentFrame(4).header);
  expect_violation(harness, "credit of 2 frames");
}

TEST(Session, ResultsThatWereNotReadKeepTheirCredit) {
  SessionHarness harness({.frames = 1, .bytes = 1000});
  harness.open();
  harness.send(SentFrame(1));
  harness.compute();
  v1::SegmentStreamResponse message;
  ASSERT_TRUE(harness.session->next(message));
  ASSERT_TRUE(message.has_outcome());
  harness.say_header(SentFrame(2).header);
  expect_violation(harness, "credit of 1 frames");
}

TEST(Session, BytesBeyondTheCreditEndTheStream) {
  SessionHarness harness({.frames = 4, .bytes = 200});
  harness.open();
  harness.say_header(SentFrame(1).header);
  ASSERT_FALSE(harness.session->ended());
  SessionHarness other({.frames = 4, .bytes = 100});
  other.open();
  other.say_header(SentFrame(1).header);
  expect_violation(other, "credit of 100 bytes");
}

void set_place(auto& message) {
  message.set_x(0.1);
  message.set_y(0.1);
  message.set_z(0.1);
}

/// A header with the largest track state and with as many cameras and prompts as the API allows.
v1::FrameHeader largest_header() {
  v1::FrameHeader header = SentFrame(1).header;
  header.set_request_id(std::string(256, 'r'));
  header.set_frame_id(std::string(256, 'f'));
  for (std::size_t i = 0; i < kMostCameras; ++i) {
    v1::CameraPoints& camera = *header.mutable_cloud()->mutable_view()->add_cameras();
    camera.set_points(1U << 31U);
    set_place(*camera.mutable_sensor());
  }
  for (std::size_t i = 0; i < kMostPrompts; ++i) {
    set_place(*header.mutable_prompts()->add_include()->mutable_position());
    set_place(*header.mutable_prompts()->add_exclude()->mutable_position());
  }
  header.mutable_tracking()->set_state(std::string(TrackState::kMostBytes, 's'));
  for (int i = 0; i < 9; ++i) header.mutable_tracking()->mutable_pose()->add_rotation(1);
  return header;
}

TEST(Session, AHeaderMayHaveAllThatTheApiAllows) {
  SessionHarness harness;
  harness.open();
  harness.say_header(largest_header());
  EXPECT_EQ(harness.outcome().kind(), v1::OUTCOME_KIND_FAILED) << "these bytes are no state";
  EXPECT_FALSE(harness.session->ended()) << *harness.session->ended();
}

TEST(Session, BreakingTheProtocolEndsTheStream) {
  const auto after_open = [](const auto& say, const std::string& text) {
    SessionHarness harness;
    harness.open();
    say(harness);
    expect_violation(harness, text);
  };
  after_open([](auto& h) { h.say({}); }, "no kind");
  after_open(
      [](auto& h) {
        h.say([] {
          v1::SegmentStreamRequest m;
          m.mutable_open();
          return m;
        }());
      },
      "second");
  after_open([](auto& h) { h.say_chunk(1, "a"); }, "not the last that has begun");
  after_open(
      [](auto& h) {
        h.send(SentFrame(5));
        h.send(SentFrame(5));
      },
      "frame 5 comes after frame 5");
  after_open(
      [](auto& h) {
        h.say_header(SentFrame(1).header);
        h.say_chunk(2, "a");
      },
      "not the last that has begun");
  after_open(
      [](auto& h) {
        h.say_header(SentFrame(1).header);
        h.say_chunk(1, "");
      },
      "chunk of 0 bytes");
  after_open(
      [](auto& h) {
        h.say_header(SentFrame(1).header);
        h.say_chunk(1, std::string(500, 'a'));
      },
      "more bytes");
  after_open(
      [](auto& h) {
        h.say_header(SentFrame(1).header);
        h.say_header(SentFrame(2).header);
      },
      "missing");
  after_open([](auto& h) { h.say_chunk(0, std::string(wire::kMaxChunkBytes + 1, 'a')); }, "not the last");
  SessionHarness unopened;
  unopened.say_header(SentFrame(1).header);
  expect_violation(unopened, "first message must be a StreamOpen");
}

TEST(Session, WrongOptionsInTheOpeningEndTheStreamWithAllTheirNames) {
  SessionHarness harness;
  v1::SegmentStreamRequest message;
  message.mutable_open()->mutable_options()->set_voxel_resolution(-1);
  message.mutable_open()->mutable_options()->set_seed_resolution(-1);
  message.mutable_open()->set_client_name(std::string(300, 'a'));
  harness.say(message);
  const auto ended = harness.session->ended();
  ASSERT_TRUE(ended);
  EXPECT_EQ(wire::details_of(*ended).fields.size(), 3U);
}

}  // namespace
}  // namespace segserve::server
