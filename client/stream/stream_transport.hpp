// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <memory>
#include <string>

#include "absl/status/status.h"
#include "client/stream/outgoing_message.hpp"
#include "core/base/mutex.hpp"
#include "grpcpp/channel.h"
#include "grpcpp/client_context.h"
#include "grpcpp/generic/generic_stub.h"
#include "grpcpp/impl/codegen/proto_utils.h"
#include "grpcpp/support/client_callback.h"
#include "segserve/v1/stream.pb.h"

namespace segserve::client {

/// Gets the events of a transport. They come from any thread, one at a time for each transport, except that
/// next_message may run beside the others. Nothing comes after on_closed.
class StreamTransportListener {
 public:
  virtual ~StreamTransportListener() = default;
  /// Fills in what is to be sent; false if there is nothing to send now.
  virtual bool next_message(std::uint64_t connection, OutgoingMessage& outgoing) = 0;
  virtual bool wants_half_close(std::uint64_t connection) = 0;
  virtual void on_written(std::uint64_t connection) = 0;
  virtual void on_message(std::uint64_t connection, v1::SegmentStreamResponse& message) = 0;
  /// `handshake_failed` as in call_status.hpp.
  virtual void on_closed(std::uint64_t connection, const absl::Status& status, bool handshake_failed) = 0;
};

/// One SegmentStream call: moves messages between gRPC and a listener. Once started it must live until on_closed. It
/// must not be destroyed on a thread of gRPC, and on_closed runs on one: gRPC 1.51 cannot destroy a channel there.
class StreamTransport final : private grpc::ClientBidiReactor<OutgoingMessage, v1::SegmentStreamResponse> {
 public:
  /// `connection` is the id that the listener gets, and `address` is where the channel leads.
  StreamTransport(std::uint64_t connection, std::string address, std::shared_ptr<grpc::Channel> channel,
                  StreamTransportListener& listener);

  /// The context of the call, before `start`.
  grpc::ClientContext& context() { return context_; }
  void start() ABSL_LOCKS_EXCLUDED(mutex_);
  /// Sends what there is to send, unless another thread is doing so.
  void pump() ABSL_LOCKS_EXCLUDED(mutex_);
  /// Ends the call as soon as possible: on_closed follows.
  void cancel() { context_.TryCancel(); }
  const std::string& address() const { return address_; }
  const std::shared_ptr<grpc::Channel>& channel() const { return channel_; }

 private:
  bool write_once() ABSL_LOCKS_EXCLUDED(mutex_);
  void OnReadDone(bool ok) override ABSL_LOCKS_EXCLUDED(mutex_);
  void OnWriteDone(bool ok) override ABSL_LOCKS_EXCLUDED(mutex_);
  void OnDone(const grpc::Status& status) override;

  const std::uint64_t connection_;
  const std::string address_;
  const std::shared_ptr<grpc::Channel> channel_;
  StreamTransportListener& listener_;
  grpc::TemplatedGenericStub<OutgoingMessage, v1::SegmentStreamResponse> stub_;
  grpc::ClientContext context_;
  OutgoingMessage request_;  // of the thread that set writing_
  v1::SegmentStreamResponse response_;

  Mutex mutex_;
  /// A write is under way, or about to be.
  bool writing_ ABSL_GUARDED_BY(mutex_) = false;
  /// True if there may be more to write than the thread that writes has seen.
  bool again_ ABSL_GUARDED_BY(mutex_) = false;
  /// Nothing may be written: the call has not started, is half-closed, or the server has no more to say.
  bool closed_ ABSL_GUARDED_BY(mutex_) = true;
};

}  // namespace segserve::client
