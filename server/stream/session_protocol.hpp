// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>
#include <cstdint>
#include <optional>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "segserve/v1/stream.pb.h"
#include "server/stream/credit.hpp"
#include "server/stream/outbox.hpp"
#include "server/stream/stream_frame.hpp"

namespace segserve::server {

/// How fast the payload of a frame must come.
struct UploadPace {
  std::chrono::milliseconds between_chunks;  ///< at most
  std::chrono::milliseconds grace;           ///< besides the time of the bytes that have come, at the least rate
  std::uint64_t least_rate;                  ///< bytes per second
  std::chrono::milliseconds most_time;       ///< for the whole payload, besides `grace`
};

/// The server's side of the rules in stream.proto for one stream: the order of messages, credit, uploads in chunks, and
/// which message is sent next. It knows neither computation nor transport nor clock. One thread at a time may use it.
class SessionProtocol {
 public:
  using Time = StreamFrame::Time;

  /// `greeting` is the answer to StreamOpen without the credit. All references must outlive this object.
  SessionProtocol(const v1::StreamOpened& greeting, Outbox& outbox) : greeting_(greeting), outbox_(outbox) {}

  /// The meaning of a message from the client.
  struct Event {
    enum Kind {
      kNothing,   ///< all is done
      kOpen,      ///< the client asks for a stream: `grant` or fail
      kBegun,     ///< `frame` has begun; its settings and payload are to be prepared
      kUploaded,  ///< the payload of `frame` is complete
      kCancel,    ///< the client does not want the frame `sequence` any more
    } kind = kNothing;
    StreamFramePointer frame = nullptr;
    std::uint64_t sequence = 0;
  };
  /// May take parts of the message. INVALID_ARGUMENT, PROTOCOL_VIOLATION, which ends the stream.
  absl::StatusOr<Event> receive(v1::SegmentStreamRequest& message, Time now);

  /// Accepts a stream, with this credit.
  void grant(const Credit& credit);

  /// The client sends no more.
  void half_close(Time now) { half_closed_ = now; }
  bool half_closed() const { return half_closed_.has_value(); }
  /// The frame that can never be complete, if there is one, a moment after `half_close`: a client that vanishes seems
  /// to close its side first, and the end of its call comes only then.
  StreamFramePointer cut_off_upload(Time now) const;
  /// The frame that is being uploaded if its chunks come more slowly than the pace.
  StreamFramePointer stalled_upload(Time now, const UploadPace& pace) const;

  /// The client shall be told to open another stream.
  void announce_draining(v1::DrainReason reason) { must_send_draining_ = reason; }
  /// Fills in the next message to send; false if there is none now. With the last message of a frame, `sent` gets that
  /// frame.
  bool next(v1::SegmentStreamResponse& message, std::optional<FinishedFrame>& sent);
  /// Whether the client has a stream.
  bool is_open() const { return open_; }
  /// True if everything was sent that there is to say at present.
  bool all_sent() const { return outbox_.empty() && !must_send_opened_; }

  /// Forgets the upload, so that nothing of the stream is kept after its end.
  void forget_upload() { upload_.reset(); }

 private:
  absl::StatusOr<Event> begin_frame(v1::FrameHeader& header, Time now);
  absl::Status take_credit(const v1::FrameHeader& header);
  absl::StatusOr<Event> take_chunk(const v1::FrameChunk& chunk, Time now);
  bool is_uploading() const { return upload_ && upload_->state == StreamFrame::State::kUploading; }

  const v1::StreamOpened& greeting_;
  Outbox& outbox_;

  Credit credit_, used_;
  bool open_ = false;
  std::optional<Time> half_closed_;
  bool must_send_opened_ = false;
  std::optional<v1::DrainReason> must_send_draining_;
  std::optional<std::uint64_t> last_sequence_;
  StreamFramePointer upload_;       // the frame that began last, also when it is over
  Time upload_began_, last_chunk_;  // of `upload_`: its header, and its last chunk or its header
};

}  // namespace segserve::server
