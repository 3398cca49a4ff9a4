// SPDX-License-Identifier: Apache-2.0
// Tests SegmentStream over the loopback with a plain stub.
#include <map>
#include <thread>

#include "gmock/gmock.h"
#include "proto/wire/codec_message.hpp"
#include "proto/wire/result_message.hpp"
#include "proto/wire/status_message.hpp"
#include "segserve/codec/draco.hpp"
#include "test/proto/example_messages.hpp"
#include "test/server/support/running_server.hpp"
#include "test/server/support/session_harness.hpp"

namespace segserve::server {
namespace {

using namespace std::chrono_literals;
using v1::FrameOutcome;

/// A stream through the synchronous API.
class StubStream {
 public:
  explicit StubStream(RunningServer& server) : stream_(server.stub().SegmentStream(&context_)) {}

  bool open(const v1::StreamOpen& open = {}) {
    v1::SegmentStreamRequest message;
    *message.mutable_open() = open;
    v1::SegmentStreamResponse answer;
    return stream_->Write(message) && stream_->Read(&answer) && answer.has_opened();
  }
  bool send(SentFrame frame, std::size_t chunk_bytes = wire::kMaxChunkBytes) {
    const std::uint64_t sequence = frame.header.sequence();
    v1::SegmentStreamRequest message;
    *message.mutable_frame() = std::move(frame.header);
    bool ok = stream_->Write(message);
    while (ok && !frame.bytes.done()) {
      const std::string_view bytes = frame.bytes.next(chunk_bytes);
      message.mutable_chunk()->set_sequence(sequence);
      message.mutable_chunk()->set_data(bytes.data(), bytes.size());
      ok = stream_->Write(message);
    }
    return ok;
  }
  void cancel(std::uint64_t sequence) {
    v1::SegmentStreamRequest message;
    message.mutable_cancel()->set_sequence(sequence);
    stream_->Write(message);
  }

  /// The next outcome with the bytes of its result; nullopt at the end of the stream.
  std::optional<FrameOutcome> next() {
    v1::SegmentStreamResponse message;
    do {
      if (!stream_->Read(&message)) return std::nullopt;
    } while (message.has_draining());
    FrameOutcome outcome = std::move(*message.mutable_outcome());
    wire::IncomingBytes bytes(wire::result_block_sizes(outcome.result()));
    while (bytes.missing() > 0 && stream_->Read(&message)) {
      EXPECT_EQ(message.chunk().sequence(), outcome.sequence());
      EXPECT_LE(message.chunk().data().size(), wire::kMaxChunkBytes);
      EXPECT_TRUE(bytes.add(message.chunk().data()));
    }
    if (bytes.missing() > 0) return std::nullopt;
    EXPECT_EQ(bytes.crc32(), outcome.crc32());
    bytes.move_to(wire::result_blocks(*outcome.mutable_result()));
    return outcome;
  }

  absl::Status finish() {
    stream_->WritesDone();
    while (next()) {
    }
    return wire::from_grpc(stream_->Finish());
  }
  void abort() { context_.TryCancel(); }

 private:
  grpc::ClientContext context_;
  std::unique_ptr<grpc::ClientReaderWriter<v1::SegmentStreamRequest, v1::SegmentStreamResponse>> stream_;
};

std::vector<std::uint32_t> labels_of(const FrameOutcome& outcome, std::size_t points) {
  return wire::from_message(outcome.result(), points).value().segmentation.labels;
}

TEST(Stream, FramesGetTheLabelsOfALocalRun) {
  RunningServer server;
  StubStream stream(server);
  ASSERT_TRUE(stream.open());
  for (std::uint32_t width = 40; width < 200; width += 40) {
    const Cloud cloud = wall_with_box(width, 90);
    ASSERT_TRUE(stream.send(SentFrame(width, cloud), 1000 + width));
    const auto outcome = stream.next();
    ASSERT_TRUE(outcome && outcome->kind() == v1::OUTCOME_KIND_RESULT) << outcome->status().message();
    EXPECT_EQ(labels_of(*outcome, cloud.size()), Segmenter().segment(cloud, Options()).value().labels);
  }
  EXPECT_EQ(stream.finish(), absl::OkStatus());
  EXPECT_TRUE(eventually([&] { return server.server().calls() == 0; }));
}

TEST(Stream, TakesEveryCodecThatTheServerAdvertises) {
  ServerOptions options = small_server();
  options.enable_draco = true;
  RunningServer server(options);
  const Cloud cloud = wall_with_box();
  StubStream stream(server);
  ASSERT_TRUE(stream.open());
  std::uint64_t sequence = 0;
  for (const wire::CodecInfo& codec : wire::codecs()) {
    SCOPED_TRACE(codec.name);
    const v1::Cloud payload = wire::to_message(cloud, {.codec = codec.codec}).value();
    const wire::DecodedCloud decoded = wire::decode_cloud(payload, {.draco = true}).value();
    ASSERT_TRUE(stream.send(SentFrame(++sequence, payload)));
    const auto outcome = stream.next();
    ASSERT_TRUE(outcome.has_value());
    ASSERT_EQ(outcome->kind(), v1::OUTCOME_KIND_RESULT) << outcome->status().message();
    EXPECT_EQ(labels_of(*outcome, cloud.size()), segment(decoded.cloud, {}).value().labels);
  }
  EXPECT_EQ(stream.finish(), absl::OkStatus());
}

TEST(Stream, RefusesDracoAtTheHeaderUnlessTheServerEnablesIt) {
  if (!codec::draco_is_built()) GTEST_SKIP() << "built without Draco";
  RunningServer server;
  StubStream stream(server);
  ASSERT_TRUE(stream.open());
  ASSERT_TRUE(stream.send(SentFrame(1, wire::to_message(wall_with_box(), {.codec = wire::Codec::kDraco}).value())));
  const auto outcome = stream.next();
  ASSERT_TRUE(outcome.has_value());
  EXPECT_EQ(outcome->kind(), v1::OUTCOME_KIND_FAILED);
  EXPECT_THAT(outcome->status().message(), testing::HasSubstr("cloud.draco: not enabled here; enabled are planar"));
  EXPECT_EQ(stream.finish(), absl::OkStatus());
}

TEST(Stream, CarriesCloudsBeyondTheUnaryLimitInBothDirections) {
  RunningServer server(small_server(), fake_factory([](const CloudView& cloud, const Options&, const StopToken&) {
                         Segmentation result;
                         result.supervoxels.assign(cloud.size(), 1);
                         for (std::size_t i = 0; i < cloud.size(); ++i) result.labels.push_back(1 + i % 70'000);
                         return absl::StatusOr<Segmentation>(result);
                       }));
  constexpr std::uint32_t kPoints = 1'500'000;  // 22 MB to the server, 6 MB back
  StubStream stream(server);
  ASSERT_TRUE(stream.open());
  ASSERT_TRUE(stream.send(SentFrame(1, equal_points(kPoints, 0, 0, 1))));
  const auto outcome = stream.next();
  ASSERT_TRUE(outcome && outcome->kind() == v1::OUTCOME_KIND_RESULT) << outcome->status().message();
  EXPECT_EQ(outcome->encoded_bytes(), 4U * kPoints);
  EXPECT_EQ(stream.finish(), absl::OkStatus());
}

TEST(Stream, CarriesTreesBeyondAChunk) {
  constexpr std::uint32_t kPoints = 70'000;
  const MergeTree tree = wire::chain_tree(kPoints);
  RunningServer server(small_server(), fake_factory([&tree](const CloudView& cloud, const Options&, const StopToken&) {
                         Segmentation result;
                         result.finite_points = result.segmented_points = cloud.size();
                         for (std::uint32_t i = 0; i < cloud.size(); ++i) result.supervoxels.push_back(1 + i);
                         result.tree = tree;
                         return absl::StatusOr<Segmentation>(result);
                       }));
  for (const auto compression : {wire::Compression::kNone, wire::Compression::kZstd}) {
    StubStream stream(server);
    v1::StreamOpen open;
    *open.mutable_outputs() =
        wire::to_message(wire::Outputs{.labels = false, .supervoxels = true, .tree = true, .compression = compression});
    ASSERT_TRUE(stream.open(open));
    ASSERT_TRUE(stream.send(SentFrame(1, equal_points(kPoints, 0, 0, 1))));
    const auto outcome = stream.next();
    ASSERT_TRUE(outcome && outcome->kind() == v1::OUTCOME_KIND_RESULT) << outcome->status().message();
    if (compression == wire::Compression::kNone) {
      EXPECT_EQ(outcome->encoded_bytes(), (4 + 1) * kPoints + (4 + 4 + 8) * (kPoints - 1));
    } else {
      EXPECT_LT(outcome->encoded_bytes(), 21 * kPoints / 2);
    }
    const auto result = wire::from_message(outcome->result(), kPoints);
    ASSERT_TRUE(result.ok()) << result.status();
    EXPECT_EQ(result->segmentation.tree, tree);
    EXPECT_EQ(stream.finish(), absl::OkStatus());
  }
}

TEST(Stream, ManyStreamsAtOnceGetTheirOwnResults) {
  ServerOptions options = small_server();
  options.workers = 2;
  RunningServer server(options);
  const auto run_client = [&server](std::uint32_t width) {
    const Cloud cloud = wall_with_box(width, 60);
    const auto expected = Segmenter().segment(cloud, Options()).value().labels;
    StubStream stream(server);
    ASSERT_TRUE(stream.open());
    for (std::uint64_t sequence = 1; sequence <= 5; ++sequence) {
      ASSERT_TRUE(stream.send(SentFrame(sequence, cloud)));
      if (sequence < 3) continue;  // three frames are on their way from now on
      const auto outcome = stream.next();
      ASSERT_TRUE(outcome);
      EXPECT_EQ(outcome->sequence(), sequence - 2);
      EXPECT_EQ(labels_of(*outcome, cloud.size()), expected);
    }
    EXPECT_EQ(stream.finish(), absl::OkStatus());
  };
  std::vector<std::thread> clients;
  for (std::uint32_t i = 0; i < 8; ++i) clients.emplace_back(run_client, 40 + 10 * i);
  for (std::thread& thread : clients) thread.join();
}

TEST(Stream, AProtocolViolationEndsItAndTheServerGoesOn) {
  RunningServer server;
  StubStream stream(server);
  stream.send(SentFrame(1));  // the server may end the stream before the frame is written
  const absl::Status status = stream.finish();
  EXPECT_EQ(wire::details_of(status).reason, wire::ErrorReason::kProtocolViolation) << status;
  StubStream other(server);
  EXPECT_TRUE(other.open());
  EXPECT_EQ(other.finish(), absl::OkStatus());
}

TEST(Stream, ACancelledFrameStopsItsComputation) {
  Blockade blockade;
  RunningServer server(small_server(), blocking_factory(blockade));
  StubStream stream(server);
  ASSERT_TRUE(stream.open());
  ASSERT_TRUE(stream.send(SentFrame(1)));
  ASSERT_TRUE(eventually([&] { return blockade.entered() == 1; }));
  stream.cancel(1);
  EXPECT_EQ(stream.next()->kind(), v1::OUTCOME_KIND_CANCELLED);
  EXPECT_EQ(blockade.stopped(), 1);
  blockade.release();
  ASSERT_TRUE(stream.send(SentFrame(2)));
  EXPECT_EQ(stream.next()->kind(), v1::OUTCOME_KIND_RESULT);
}

TEST(Stream, AClientThatVanishesFreesItsWorker) {
  Blockade blockade;
  RunningServer server(small_server(), blocking_factory(blockade));
  StubStream stream(server);
  ASSERT_TRUE(stream.open());
  ASSERT_TRUE(stream.send(SentFrame(1)));
  ASSERT_TRUE(eventually([&] { return blockade.entered() == 1; }));
  stream.abort();
  EXPECT_TRUE(absl::IsCancelled(stream.finish()));
  EXPECT_TRUE(eventually([&] { return server.server().calls() == 0; }));
  EXPECT_EQ(blockade.stopped(), 1);
}

TEST(Stream, ExpiredWhileItWaits) {
  Blockade blockade;
  RunningServer server(small_server(), blocking_factory(blockade));
  StubStream stream(server);
  v1::StreamOpen unordered;
  unordered.set_order(v1::RESULT_ORDER_UNORDERED);
  ASSERT_TRUE(stream.open(unordered));
  ASSERT_TRUE(stream.send(SentFrame(1)));
  SentFrame old(2);
  old.header.mutable_time_to_live()->set_seconds(5);
  old.header.mutable_age()->set_seconds(5);
  ASSERT_TRUE(stream.send(old));
  const auto outcome = stream.next();
  EXPECT_EQ(outcome->sequence(), 2U);
  EXPECT_EQ(outcome->kind(), v1::OUTCOME_KIND_EXPIRED);
  blockade.release();
  EXPECT_EQ(stream.next()->kind(), v1::OUTCOME_KIND_RESULT);
}

TEST(Stream, DrainingFinishesTheFramesInFlight) {
  Blockade blockade;
  RunningServer server(small_server(), blocking_factory(blockade));
  StubStream stream(server);
  ASSERT_TRUE(stream.open());
  ASSERT_TRUE(stream.send(SentFrame(1)));
  ASSERT_TRUE(eventually([&] { return blockade.entered() == 1; }));
  auto stopped = std::async(std::launch::async, [&] { return server.server().stop(); });
  ASSERT_TRUE(eventually([&] { return server.health() != grpc::health::v1::HealthCheckResponse::SERVING; }));
  blockade.release();
  EXPECT_EQ(stream.next()->kind(), v1::OUTCOME_KIND_RESULT);
  const absl::Status ended = stream.finish();
  EXPECT_TRUE(ended.ok() || absl::IsUnavailable(ended)) << ended;
  EXPECT_TRUE(stopped.get()) << "nothing had to be cancelled";
}

TEST(Stream, AnIdleStreamDoesNotHoldADrainingServer) {
  RunningServer server;
  StubStream stream(server);
  ASSERT_TRUE(stream.open());
  EXPECT_TRUE(server.server().stop());
  EXPECT_EQ(stream.finish().code(), absl::StatusCode::kUnavailable);
}

TEST(Stream, AClientThatDoesNotReadEndsWithTheGracePeriod) {
  std::atomic<int> segmented{0};
  ServerOptions options = small_server();
  options.grace_period = 300ms;
  RunningServer server(options, fake_factory([&](const CloudView& cloud, const Options&, const StopToken&) {
                         Segmentation result;
                         result.labels.assign(cloud.size(), 70'000);
                         ++segmented;
                         return absl::StatusOr<Segmentation>(result);
                       }));
  const auto cloud = wire::to_planar_message(equal_points(2'000'000, 0, 0, 1), v1::COMPRESSION_ZSTD).value();
  StubStream stream(server);
  ASSERT_TRUE(stream.open());
  for (std::uint64_t sequence = 1; sequence <= 8; ++sequence) {  // the results are 64 MB, beyond any window of HTTP/2
    ASSERT_TRUE(stream.send(SentFrame(sequence, cloud)));
  }
  ASSERT_TRUE(eventually([&] { return segmented == 8; }));
  EXPECT_FALSE(server.server().stop());
  EXPECT_FALSE(stream.finish().ok());
}

}  // namespace
}  // namespace segserve::server
