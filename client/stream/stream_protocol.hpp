// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <deque>
#include <map>
#include <optional>

#include "absl/status/statusor.h"
#include "client/stream/outgoing_message.hpp"
#include "proto/wire/byte_run.hpp"
#include "segserve/client/payload.hpp"
#include "segserve/v1/stream.pb.h"

namespace segserve::client {

/// The client's side of the protocol in stream.proto, on one connection: numbers the frames, keeps to the credit, cuts
/// payloads into chunks and joins the chunks of results. Knows neither transport nor clock; one thread at a time may
/// use it.
///
/// Callers name frames by the stream's sequence. On the wire frames have numbers of their own, because a frame may be
/// sent twice on one connection.
class StreamProtocol {
 public:
  explicit StreamProtocol(v1::StreamOpen open);

  /// True once the server has granted credit.
  bool opened() const { return opened_; }
  /// True if no new frame may begin: the server is about to stop, or end() was called.
  bool ending() const { return draining_ || ending_; }
  /// Whether a frame may begin now, as far as the upload before it and the credit in frames are concerned.
  bool has_turn() const;
  /// How many frames have no outcome.
  std::size_t in_flight() const { return sent_.size(); }

  enum class Fit { kNow, kLater, kNever };
  /// Whether the credit in bytes has room for so many bytes now, or ever.
  Fit fit(std::uint64_t bytes) const;
  /// The credit in bytes that the server has granted.
  std::uint64_t credit_bytes() const { return credit_.bytes(); }

  /// Begins the next frame. has_turn() must be true and the payload must fit. Sets the header's number, cloud, bytes
  /// and CRC.
  void begin(std::uint64_t sequence, v1::FrameHeader header, const Payload& payload);
  /// Asks the server to drop the frame; its outcome comes all the same. Unknown frames are left alone.
  void cancel(std::uint64_t sequence);
  /// Tells that no more frames will begin.
  void end() { ending_ = true; }

  struct Sent {
    std::optional<std::uint64_t> sequence;  ///< of the frame that the message is a part of
    bool completes_payload = false;
  };
  /// Replaces `outgoing` by the message to be sent next. Nothing if there is none now.
  std::optional<Sent> next(OutgoingMessage& outgoing);
  /// True after end(), once nothing will be sent any more.
  bool wants_half_close() const;

  /// The meaning of a message from the server. kDraining: it takes no more frames. kTokenOver: it takes none on this
  /// stream, whose token it accepts no longer. kOld: it asks for another stream, and takes frames until then.
  struct Event {
    enum Kind { kNothing, kOpened, kDraining, kTokenOver, kOld, kBegun, kOutcome } kind = kNothing;
    std::uint64_t sequence = 0;     ///< kBegun, kOutcome
    v1::FrameOutcome outcome = {};  ///< kOutcome: complete, with the bytes of the result in its blocks
    bool intact = true;             ///< kOutcome: false if the checksum differs from the one that was announced
  };
  /// Takes a message from the server. INTERNAL if the server broke the protocol; the connection is of no use then.
  absl::StatusOr<Event> receive(v1::SegmentStreamResponse& message);

 private:
  struct SentFrame {
    std::uint64_t sequence = 0;
    std::uint64_t bytes = 0;
    std::uint64_t points = 0;  // 0: not known
  };
  Sent next_header(OutgoingMessage& outgoing);
  Sent next_cancel(OutgoingMessage& outgoing);
  Sent next_chunk(OutgoingMessage& outgoing);
  absl::StatusOr<Event> receive_opened(const v1::StreamOpened& opened);
  absl::StatusOr<Event> receive_outcome(v1::FrameOutcome& outcome);
  absl::StatusOr<Event> receive_chunk(const v1::ResultChunk& chunk);
  Event complete_outcome();
  void forget(std::uint64_t number);

  v1::StreamOpen open_;
  bool open_sent_ = false, opened_ = false, draining_ = false, ending_ = false;
  v1::Credit credit_;  // that was granted
  std::size_t chunk_bytes_ = 0;
  std::uint64_t bytes_used_ = 0;  // of the credit
  std::uint64_t last_number_ = 0;
  std::map<std::uint64_t, SentFrame> sent_;  // by number on the wire
  std::deque<std::uint64_t> cancels_;        // numbers on the wire

  std::uint64_t upload_ = 0;  // number of the frame whose payload is being sent; 0: none
  std::optional<v1::FrameHeader> header_;
  wire::OutgoingBytes payload_;

  std::optional<v1::FrameOutcome> outcome_;  // whose bytes are arriving
  wire::IncomingBytes outcome_bytes_;
};

}  // namespace segserve::client
