// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <atomic>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <list>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "gtest/gtest.h"
#include "proto/wire/byte_run.hpp"
#include "proto/wire/cloud_message.hpp"
#include "proto/wire/payload_blocks.hpp"
#include "proto/wire/request_message.hpp"
#include "proto/wire/result_blocks.hpp"
#include "proto/wire/status_message.hpp"
#include "server/stream/stream_session.hpp"
#include "test/server/support/fake_backend.hpp"
#include "test/server/support/record_keeper.hpp"
#include "test/server/support/server_scenes.hpp"

namespace segserve::server {

/// Keeps jobs until the test runs them.
class ManualExecutor final : public FrameExecutor {
 public:
  absl::StatusOr<Ticket> submit(FrameJob job) override {
    if (!job.may_exceed_queue && jobs_.size() >= capacity) {
      return wire::with_details(absl::ResourceExhaustedError("full"), {.reason = wire::ErrorReason::kQueueFull});
    }
    jobs_.emplace_back(++last_, std::move(job));
    return last_;
  }
  bool withdraw(Ticket ticket) override {
    return std::erase_if(jobs_, [ticket](const auto& entry) { return entry.first == ticket; }) > 0;
  }
  std::chrono::nanoseconds expected_time(std::uint64_t /*points*/) const override { return time_of_a_frame; }

  /// Takes the oldest job out, as a worker does.
  FrameJob take() {
    FrameJob job = std::move(jobs_.front().second);
    jobs_.pop_front();
    return job;
  }
  std::size_t queued() const { return jobs_.size(); }
  const FrameJob& first() const { return jobs_.front().second; }

  std::size_t capacity = 1000;
  std::chrono::nanoseconds time_of_a_frame{};

 private:
  std::list<std::pair<Ticket, FrameJob>> jobs_;
  Ticket last_ = 0;
};

/// A frame as a client sends it: the header, and the bytes of the payload.
struct SentFrame {
  v1::FrameHeader header;
  wire::OutgoingBytes bytes;

  SentFrame(std::uint64_t sequence, v1::Cloud cloud) {
    header.set_sequence(sequence);
    *header.mutable_cloud() = std::move(cloud);
    bytes = wire::OutgoingBytes(std::make_shared<const wire::ByteRun>(wire::payload_blocks(*header.mutable_cloud())));
    header.set_encoded_bytes(bytes.run().size());
    header.set_crc32(bytes.run().crc32());
  }
  explicit SentFrame(std::uint64_t sequence, const CloudView& cloud = equal_points(9, 0, 0, 1))
      : SentFrame(sequence, wire::to_planar_message(cloud, v1::COMPRESSION_NONE).value()) {}
};

/// A session whose clock, workers and backend are in the test's hands.
class SessionHarness {
 public:
  using Response = v1::SegmentStreamResponse;

  explicit SessionHarness(Credit credit = {.frames = 4, .bytes = 1 << 20})
      : backend_([this](const CloudView& cloud, const Options& options, const StopToken& stop) {
          return on_segment ? on_segment(cloud, options, stop) : absl::StatusOr<Segmentation>(all_in_one(cloud));
        }) {
    settings.now = [this] { return now; };
    settings.credit = {.most_per_stream = credit, .default_bytes_per_stream = credit.bytes};
    settings.ledger = &ledger;
    settings.max_voxels = 1000;
    settings.observers = ServiceObservers({records});
    session = std::make_shared<StreamSession>(settings, MemoryOwner{"here", "me"}, Caller{.peer = "me"}, executor,
                                              [this] { ++wakes; });
  }

  static ServerOptions limited(std::uint32_t threads = 1) {
    ServerOptions options;
    options.max_points = 1000;
    options.max_decoded_bytes = 1 << 20;
    options.threads = threads;
    return options;
  }

  static Segmentation all_in_one(const CloudView& cloud) {
    Segmentation result;
    result.labels.assign(cloud.size(), 1);
    result.supervoxels.assign(cloud.size(), 1);
    return result;
  }

  void say(v1::SegmentStreamRequest message) { session->on_message(message); }
  void open(const v1::StreamOpen& open = {}) {
    v1::SegmentStreamRequest message;
    *message.mutable_open() = open;
    say(message);
    for (const Response& response : read()) EXPECT_TRUE(response.has_opened()) << response.DebugString();
  }
  void say_header(const v1::FrameHeader& header) {
    v1::SegmentStreamRequest message;
    *message.mutable_frame() = header;
    say(message);
  }
  void say_chunk(std::uint64_t sequence, std::string_view data) {
    v1::SegmentStreamRequest message;
    message.mutable_chunk()->set_sequence(sequence);
    message.mutable_chunk()->set_data(data.data(), data.size());
    say(message);
  }
  void say_cancel(std::uint64_t sequence) {
    v1::SegmentStreamRequest message;
    message.mutable_cancel()->set_sequence(sequence);
    say(message);
  }
  void send(SentFrame frame, std::size_t chunk_bytes = wire::kMaxChunkBytes) {
    say_header(frame.header);
    while (!frame.bytes.done()) say_chunk(frame.header.sequence(), frame.bytes.next(chunk_bytes));
  }

  /// Runs the oldest job in the queue.
  void compute() { executor.take().run(backend_); }
  SegmentationBackend& backend() { return backend_; }

  /// All messages that the session has to send now.
  std::vector<Response> read() {
    std::vector<Response> responses(1);
    while (session->next(responses.back())) responses.emplace_back();
    responses.pop_back();
    return responses;
  }
  /// The outcomes among these messages.
  std::vector<v1::FrameOutcome> outcomes() {
    std::vector<v1::FrameOutcome> found;
    for (const Response& response : read()) {
      if (response.has_outcome()) found.push_back(response.outcome());
    }
    return found;
  }
  /// The outcome, if there is exactly one, which is expected.
  v1::FrameOutcome outcome() {
    const auto found = outcomes();
    EXPECT_EQ(found.size(), 1U);
    return found.empty() ? v1::FrameOutcome() : found.front();
  }

  static constexpr std::uint64_t kMemory = 1 << 20;
  MemoryLedger ledger{kMemory};
  std::shared_ptr<RecordKeeper> records = std::make_shared<RecordKeeper>();
  StreamSettings settings{.resolver = FrameResolver(limited())};  // not to be changed after `open`
  StreamSettings::Clock::time_point now =
      StreamSettings::Clock::now() + std::chrono::hours(1);  // so that no real time expires
  ManualExecutor executor;
  FakeBackend::Function on_segment;
  std::atomic<int> wakes{0};

 private:
  FakeBackend backend_;

 public:
  std::shared_ptr<StreamSession> session;  // is destroyed first
};

inline wire::ErrorReason reason_of(const v1::FrameOutcome& outcome) {
  return wire::details_of(wire::from_message(outcome.status())).reason;
}

inline std::vector<std::uint64_t> sequences(const std::vector<v1::FrameOutcome>& outcomes) {
  std::vector<std::uint64_t> numbers;
  for (const v1::FrameOutcome& outcome : outcomes) numbers.push_back(outcome.sequence());
  return numbers;
}

inline v1::StreamOpen opening(v1::WhenBehind when_behind, v1::ResultOrder order = v1::RESULT_ORDER_ORDERED) {
  v1::StreamOpen open;
  open.set_when_behind(when_behind);
  open.set_order(order);
  return open;
}

}  // namespace segserve::server
