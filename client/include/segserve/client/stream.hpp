#pragma once

#include <chrono>
#include <cstdint>
#include <memory>
#include <optional>

#include "absl/status/statusor.h"
#include "segserve/client/frame.hpp"
#include "segserve/client/payload.hpp"
#include "segserve/client/stream_options.hpp"

namespace segserve::client {

class StreamDriver;

/// A stream of frames to whichever server is in reach, made by Client::open_stream. example_stream.cpp shows it.
///
/// Every frame that send() took ends in exactly one Outcome: also when the server stops, the connection breaks or
/// goes silent. Unfinished frames then go to another server, which is safe because a result is a pure function of
/// the frame.
///
/// send() and next() may be called by different threads. One thread that calls both must take outcomes before it
/// has sent max_in_flight + max_waiting more frames, or send() waits for it in vain.
class Stream {
 public:
  Stream(std::shared_ptr<StreamDriver> driver, const wire::CodecOptions& codec);
  Stream(Stream&&) noexcept = default;
  Stream& operator=(Stream&& other) noexcept;
  Stream(const Stream&) = delete;
  Stream& operator=(const Stream&) = delete;
  /// Cancels what is unfinished.
  ~Stream();

  /// Hands a frame over, which is copied before send() returns, and returns its sequence: 1, 2, .. Does not wait for
  /// the server, but, when behind, as StreamOptions::when_behind says. Errors: INVALID_ARGUMENT (a cloud whose planes
  /// do not fit each other), RESOURCE_EXHAUSTED (kReject), DEADLINE_EXCEEDED (kBlock), FAILED_PRECONDITION after
  /// finish(), or the error for which no server will ever take a frame of this stream.
  absl::StatusOr<std::uint64_t> send(const CloudView& cloud, FrameOptions options = {});
  absl::StatusOr<std::uint64_t> send(Payload payload, FrameOptions options = {});
  /// The same for a cloud that must not change before its outcome has come: the codec `planar` then sends it from where
  /// it is, without a copy (1 ms of a frame of 640 x 480).
  absl::StatusOr<std::uint64_t> send(std::shared_ptr<const Cloud> cloud, FrameOptions options = {});

  /// The next outcome. Nothing when `timeout` is over, or when finish() was called and every outcome was taken.
  std::optional<Outcome> next(std::optional<std::chrono::milliseconds> timeout = std::nullopt);

  /// The frame is not wanted any more: it ends as CANCELLED, unless its result is faster.
  void cancel(std::uint64_t sequence);

  /// No more frames will be sent; those that were end as usual.
  void finish();
  /// True once finish() was called and every outcome was taken.
  bool done() const;

 private:
  absl::StatusOr<std::uint64_t> send_made(absl::StatusOr<Payload> payload, FrameOptions options);

  std::shared_ptr<StreamDriver> driver_;
  wire::CodecOptions codec_;
};

}  // namespace segserve::client
