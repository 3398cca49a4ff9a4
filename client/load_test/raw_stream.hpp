// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>
#include <memory>

#include "client/calls/channels.hpp"
#include "grpcpp/client_context.h"
#include "grpcpp/support/sync_stream.h"
#include "segserve/client/client.hpp"
#include "segserve/client/payload.hpp"
#include "segserve/v1/segmentation_service.grpc.pb.h"

namespace segserve::bench {

/// A stream to one server without the care of the client library: it sends and reads only what it is told to. The end
/// of the object cuts its connection, whatever is on its way.
class RawStream {
 public:
  /// Connects to the first server. Its calls fail after `timeout`.
  RawStream(const client::ClientOptions& options, std::chrono::milliseconds timeout);
  ~RawStream();
  RawStream(const RawStream&) = delete;
  RawStream& operator=(const RawStream&) = delete;

  /// Opens the stream and waits for the server's answer; false if there is none.
  bool open(const std::string& client_name);
  /// How many frames the server takes before it has given a result for one, at least 1; after open().
  std::uint32_t credit() const { return opened_.opened().credit().frames(); }
  /// Sends the header of a frame, and its payload but for the last `left_out` bytes; false if the stream has ended.
  bool send_frame(const client::Payload& payload, std::uint64_t left_out);
  /// Reads one message; false if the stream has ended.
  bool read();
  /// Ends the stream, so that other threads that use it go on. Any thread may call it at any time.
  void cancel() { context_.TryCancel(); }

 private:
  std::shared_ptr<client::Channels> channels_;  // null: wrong options
  grpc::ClientContext context_;
  std::unique_ptr<grpc::ClientReaderWriter<v1::SegmentStreamRequest, v1::SegmentStreamResponse>> call_;
  v1::SegmentStreamResponse opened_;
  std::uint64_t sequence_ = 0;
};

}  // namespace segserve::bench
