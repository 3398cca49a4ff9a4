#pragma once

#include <cstdint>
#include <memory>
#include <mutex>
#include <string>

#include "absl/status/status.h"
#include "client/calls/serialise.hpp"
#include "grpcpp/channel.h"
#include "grpcpp/client_context.h"
#include "grpcpp/generic/generic_stub.h"
#include "grpcpp/impl/codegen/proto_utils.h"
#include "grpcpp/support/client_callback.h"
#include "segserve/v1/stream.pb.h"

namespace segserve::client {

/// What a call tells and asks of the one who decides. All may come from any thread, but none while another of the
/// same call's runs, except next_message. Nothing comes after on_closed.
class StreamCallListener {
 public:
  virtual ~StreamCallListener() = default;
  /// Fills in what is to be sent; false if nothing is now.
  virtual bool next_message(std::uint64_t call, Outgoing& outgoing) = 0;
  virtual bool wants_half_close(std::uint64_t call) = 0;
  virtual void on_written(std::uint64_t call) = 0;
  virtual void on_message(std::uint64_t call, v1::SegmentStreamResponse& message) = 0;
  virtual void on_closed(std::uint64_t call, const absl::Status& status) = 0;
};

/// One SegmentStream call: moves messages between gRPC and its listener. Once started it must live until on_closed,
/// and must not die in a thread of gRPC's (that of on_closed is one): gRPC 1.51 cannot destroy a channel there.
class StreamCall final : private grpc::ClientBidiReactor<Outgoing, v1::SegmentStreamResponse> {
 public:
  StreamCall(std::uint64_t id, std::string address, std::shared_ptr<grpc::Channel> channel,
             StreamCallListener& listener);

  void start();
  /// Sends what there is to send, unless it is doing so.
  void pump();
  void cancel() { context_.TryCancel(); }
  const std::shared_ptr<grpc::Channel>& channel() const { return channel_; }

 private:
  bool write_once();
  void OnReadDone(bool ok) override;
  void OnWriteDone(bool ok) override;
  void OnDone(const grpc::Status& status) override;

  const std::uint64_t id_;
  const std::string address_;
  const std::shared_ptr<grpc::Channel> channel_;
  StreamCallListener& listener_;
  grpc::TemplatedGenericStub<Outgoing, v1::SegmentStreamResponse> stub_;
  grpc::ClientContext context_;
  Outgoing request_;
  v1::SegmentStreamResponse response_;

  std::mutex mutex_;
  bool writing_ = false;  // a write is under way, or about to be
  bool again_ = false;    // there may be more to write than the one who writes has seen
  bool closed_ = true;    // not started, half-closed, or the server has no more to say: nothing may be written
};

}  // namespace segserve::client
