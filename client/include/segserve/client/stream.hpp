// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>
#include <cstdint>
#include <memory>
#include <optional>

#include "absl/status/statusor.h"
#include "segserve/client/frame.hpp"
#include "segserve/client/payload.hpp"
#include "segserve/cloud.hpp"
#include "segserve/wire/codec.hpp"

namespace segserve::client {

class StreamThreads;

/// A stream of frames to all servers that are in reach, made by Client::open_stream. Each frame goes to the one that is
/// likely to be done with it first. example_stream.cpp shows it whole.
///
///     auto stream = client.open_stream().value();
///     stream.send(cloud).IgnoreError();
///     stream.finish();
///     while (const auto outcome = stream.next()) use(*outcome);
///
/// Every frame that send() accepts ends in exactly one Outcome, also when the server stops, the connection breaks or
/// the network goes silent. Unfinished frames then go to another server, which may get them beside a silent one, which
/// is safe because a result is a pure function of the frame.
///
/// Any number of threads may call the functions at the same time; moving and destroying the stream excepted. A thread
/// that calls both send() and next() must take outcomes before it has sent max_in_flight + max_waiting frames more than
/// it has taken: with WhenBehind::kBlock, send() would otherwise wait in vain until the timeout.
class Stream {
 public:
  Stream(Stream&&) noexcept = default;
  Stream& operator=(Stream&& other) noexcept;
  Stream(const Stream&) = delete;
  Stream& operator=(const Stream&) = delete;
  /// Cancels the unfinished frames and waits for the threads of the stream.
  ~Stream();

  /// Hands a frame over, of which the stream keeps a copy, and returns its sequence: 1, 2, 3 and so on. Does not wait
  /// for the server, except as StreamOptions::when_behind says.
  ///
  /// INVALID_ARGUMENT: the planes of the cloud do not fit each other, the codec cannot encode it, or the traceparent is
  /// not valid.
  /// RESOURCE_EXHAUSTED: too many frames wait (kReject). DEADLINE_EXCEEDED: too many frames waited for the timeout of
  /// this one (kBlock). FAILED_PRECONDITION: finish() was called. Any other error is one for which no server will ever
  /// take a frame of this stream.
  absl::StatusOr<std::uint64_t> send(const CloudView& cloud, FrameOptions options = {});
  /// Hands over a frame that is encoded already.
  absl::StatusOr<std::uint64_t> send(Payload payload, FrameOptions options = {});
  /// Hands over a cloud that must not change before its outcome has come. The codec `planar` sends it without a copy.
  absl::StatusOr<std::uint64_t> send(std::shared_ptr<const Cloud> cloud, FrameOptions options = {});

  /// Waits for the next outcome, without limit if `timeout` is unset. Nothing if `timeout` is over, or if finish() was
  /// called and every outcome was taken.
  std::optional<Outcome> next(std::optional<std::chrono::milliseconds> timeout = std::nullopt);

  /// The frame is not wanted any more: it ends as kCancelled, unless its result is faster. Unknown and finished frames
  /// are left alone.
  void cancel(std::uint64_t sequence);

  /// No more frames will be sent. Those that were sent end as usual.
  void finish();
  /// True once finish() was called and every outcome was taken.
  bool done() const;

 private:
  friend class Client;
  Stream(std::shared_ptr<StreamThreads> threads, const wire::CodecOptions& codec);

  absl::StatusOr<std::uint64_t> send_encoded(absl::StatusOr<Payload> payload, FrameOptions options);

  std::shared_ptr<StreamThreads> threads_;
  wire::CodecOptions codec_;
};

}  // namespace segserve::client
