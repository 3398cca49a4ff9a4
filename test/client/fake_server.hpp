// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <atomic>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "client/calls/local.hpp"
#include "client/calls/payload_data.hpp"
#include "core/base/mutex.hpp"
#include "fmt/format.h"
#include "grpcpp/security/server_credentials.h"
#include "grpcpp/server.h"
#include "grpcpp/server_builder.h"
#include "proto/wire/byte_run.hpp"
#include "proto/wire/options_message.hpp"
#include "proto/wire/payload_blocks.hpp"
#include "proto/wire/request_message.hpp"
#include "proto/wire/result_blocks.hpp"
#include "proto/wire/result_message.hpp"
#include "proto/wire/status_message.hpp"
#include "segserve/client/payload.hpp"
#include "segserve/v1/segmentation_service.grpc.pb.h"

namespace segserve::client {

/// A server for streams that handles one frame after the other and misbehaves as the test says.
class FakeServer final : public v1::SegmentationService::Service {
 public:
  enum Answer {
    kResult,         ///< segments the frame
    kDamagedResult,  ///< segments the frame and announces a wrong checksum
    kChecksum,       ///< fails the frame with ABORTED, as if its payload had been damaged
    kBusy,           ///< fails the frame with RESOURCE_EXHAUSTED and RetryInfo
    kInvalid,        ///< fails the frame with INVALID_ARGUMENT
    kDropped,        ///< drops the frame
    kBreak,          ///< ends the call with CANCELLED, as a server that is killed does
    kUnknownFrame,   ///< ends a frame that was never sent, which breaks the protocol
    kNothing,        ///< says nothing about the frame
  };
  using Stream = grpc::ServerReaderWriter<v1::SegmentStreamResponse, v1::SegmentStreamRequest>;

  FakeServer() { start("127.0.0.1:0"); }
  FakeServer(const FakeServer&) = delete;
  FakeServer& operator=(const FakeServer&) = delete;
  ~FakeServer() override { stop(); }

  const std::string& address() const { return address_; }

  /// Says what to do with a frame. Called by the thread of its stream.
  std::function<Answer(const v1::FrameHeader&)> answer = [](const auto&) { return kResult; };
  /// Called before a frame is answered.
  std::function<void()> before_answer = [] {};
  std::atomic<std::uint32_t> credit_frames{4};
  std::atomic<std::uint64_t> credit_bytes{64U << 20U};
  std::atomic<bool> refuses_streams{false};  ///< with UNIMPLEMENTED
  std::atomic<bool> drains{false};           ///< says so before its next answer, and takes no more frames
  /// How many streams were opened, headers and cancels came, and results were sent, so far.
  std::atomic<int> streams{0}, frames{0}, cancels{0}, answered{0};

  /// From now on the server neither answers nor reads, like a machine whose cable was cut.
  void go_silent() { silent_ = true; }

  /// Shuts down at once, which breaks all streams.
  void stop() ABSL_LOCKS_EXCLUDED(mutex_) {
    {
      const MutexLock lock(mutex_);
      stopped_ = true;
      changed_.notify_all();
    }
    if (server_) server_->Shutdown(std::chrono::system_clock::now());
    server_.reset();
  }

  /// After stop(): listens at the same address again.
  void restart() ABSL_LOCKS_EXCLUDED(mutex_) {
    {
      const MutexLock lock(mutex_);
      stopped_ = false;
    }
    silent_ = drains = false;
    start(address_);
  }

  grpc::Status GetServerInfo(grpc::ServerContext*, const v1::GetServerInfoRequest*,
                             v1::GetServerInfoResponse*) override {
    wait_while_silent();
    return grpc::Status::OK;
  }

  grpc::Status SegmentStream(grpc::ServerContext*, Stream* stream) override {
    v1::SegmentStreamRequest request;
    if (refuses_streams) return {grpc::StatusCode::UNIMPLEMENTED, "no streams here"};
    wait_while_silent();
    if (drains) return wire::to_grpc(draining());
    if (!stream->Read(&request) || !request.has_open()) return {grpc::StatusCode::INVALID_ARGUMENT, "no open"};
    ++streams;
    const v1::StreamOpen open = request.open();
    open_stream(*stream);
    bool told = false;
    v1::FrameHeader header;
    wire::IncomingBytes bytes;
    while (stream->Read(&request)) {
      wait_while_silent();
      if (request.has_cancel()) {
        ++cancels;
        continue;
      }
      if (request.has_frame()) {
        ++frames;
        header = request.frame();
        bytes = wire::IncomingBytes(wire::payload_block_sizes(header.cloud()));
      } else if (!bytes.add(request.chunk().data())) {
        return {grpc::StatusCode::INVALID_ARGUMENT, "too many bytes"};
      }
      if (bytes.missing() > 0) continue;
      if (bytes.crc32() != header.crc32()) return {grpc::StatusCode::INVALID_ARGUMENT, "wrong crc"};
      bytes.move_to(wire::payload_blocks(*header.mutable_cloud()));
      before_answer();
      if (told) {
        fail(*stream, header, draining());
        continue;
      }
      if (drains) {
        told = true;
        v1::SegmentStreamResponse response;
        response.mutable_draining();
        stream->Write(response);
      }
      if (!answer_frame(*stream, open, header)) return {grpc::StatusCode::CANCELLED, ""};
    }
    return grpc::Status::OK;
  }

 private:
  void start(const std::string& address) {
    int port = 0;
    grpc::ServerBuilder builder;
    builder.AddListeningPort(address, grpc::InsecureServerCredentials(), &port);
    builder.RegisterService(this);
    server_ = builder.BuildAndStart();
    if (!server_) throw std::runtime_error("the fake server cannot listen on " + address);
    address_ = fmt::format("127.0.0.1:{}", port);
  }

  void wait_while_silent() ABSL_LOCKS_EXCLUDED(mutex_) {
    const MutexLock lock(mutex_);
    while (silent_ && !stopped_) changed_.wait(mutex_);
  }

  static absl::Status draining() {
    return wire::with_reason(absl::UnavailableError("about to stop"), wire::ErrorReason::kDraining);
  }

  void open_stream(Stream& stream) {
    v1::SegmentStreamResponse response;
    response.mutable_opened()->mutable_credit()->set_frames(credit_frames);
    response.mutable_opened()->mutable_credit()->set_bytes(credit_bytes);
    response.mutable_opened()->set_max_chunk_bytes(10'000);
    stream.Write(response);
  }

  static v1::FrameOutcome outcome_of(const v1::FrameHeader& header, v1::OutcomeKind kind) {
    v1::FrameOutcome outcome;
    outcome.set_sequence(header.sequence());
    outcome.set_kind(kind);
    return outcome;
  }

  static void fail(Stream& stream, const v1::FrameHeader& header, const absl::Status& status) {
    v1::SegmentStreamResponse response;
    *response.mutable_outcome() = outcome_of(header, v1::OUTCOME_KIND_FAILED);
    *response.mutable_outcome()->mutable_status() = wire::to_message(status);
    stream.Write(response);
  }

  bool answer_frame(Stream& stream, const v1::StreamOpen& open, const v1::FrameHeader& header) {
    const Answer what = answer(header);
    v1::SegmentStreamResponse response;
    switch (what) {
      case kNothing:
        return true;
      case kBreak:
        return false;
      case kChecksum:
        fail(stream, header, wire::with_reason(absl::AbortedError("crc"), wire::ErrorReason::kChecksum));
        return true;
      case kBusy:
        fail(stream, header,
             wire::with_details(absl::ResourceExhaustedError("busy"), {.reason = wire::ErrorReason::kQueueFull,
                                                                       .retry_delay = std::chrono::milliseconds(20)}));
        return true;
      case kInvalid:
        fail(stream, header, wire::malformed("no cloud at all"));
        return true;
      case kDropped:
        *response.mutable_outcome() = outcome_of(header, v1::OUTCOME_KIND_DROPPED);
        return stream.Write(response);
      case kUnknownFrame:
        *response.mutable_outcome() = outcome_of(header, v1::OUTCOME_KIND_DROPPED);
        response.mutable_outcome()->set_sequence(header.sequence() + 1000);
        return stream.Write(response);
      case kResult:
      case kDamagedResult:
        break;
    }
    ++answered;  // before the client can see the result
    send_result(stream, open, header, what == kDamagedResult);
    return true;
  }

  static void send_result(Stream& stream, const v1::StreamOpen& open, const v1::FrameHeader& header, bool damaged) {
    std::vector<FieldViolation> faults;
    const Options options =
        wire::from_message(header.has_options() ? header.options() : open.options(), Options{}, faults);
    const v1::Outputs& asked = header.has_outputs() ? header.outputs() : open.outputs();
    const wire::Outputs outputs{asked.labels(), asked.supervoxels(), asked.tree(), asked.segments(),
                                wire::Compression::kZstd};
    const auto result = segment_here(make_payload(header.cloud(), header.points()), options, outputs, StopToken());
    if (!result.ok()) return fail(stream, header, result.status());
    v1::SegmentStreamResponse response;
    v1::FrameOutcome& outcome = *response.mutable_outcome();
    outcome = outcome_of(header, v1::OUTCOME_KIND_RESULT);
    *outcome.mutable_result() = wire::to_message(*result, outputs).value();
    wire::OutgoingBytes bytes(std::make_shared<const wire::ByteRun>(wire::result_blocks(*outcome.mutable_result())));
    outcome.set_encoded_bytes(bytes.run().size());
    outcome.set_crc32(bytes.run().crc32() ^ (damaged ? 1U : 0U));
    stream.Write(response);
    while (!bytes.done()) {
      response.mutable_chunk()->set_sequence(header.sequence());
      response.mutable_chunk()->set_data(std::string(bytes.next(1000)));
      stream.Write(response);
    }
  }

  Mutex mutex_;
  CondVar changed_;
  bool stopped_ ABSL_GUARDED_BY(mutex_) = false;
  std::atomic<bool> silent_{false};
  std::string address_;
  std::unique_ptr<grpc::Server> server_;
};

}  // namespace segserve::client
