#pragma once

#include <cstddef>
#include <cstdint>
#include <deque>
#include <map>
#include <optional>
#include <string>

#include "absl/status/statusor.h"
#include "client/stream/outgoing.hpp"
#include "proto/wire/byte_run.hpp"
#include "segserve/client/payload.hpp"
#include "segserve/v1/segmentation_service.pb.h"

namespace segserve::client {

/// The client's side of the protocol of stream.proto on one connection: numbers frames, keeps to the credit,
/// cuts payloads into chunks and puts results together. Knows no transport and no clock; one thread at a time.
/// Frames are called by the stream's sequence; on the wire they have numbers of their own, because a frame may
/// be sent twice on one connection.
class Connection {
 public:
  explicit Connection(v1::StreamOpen open);

  bool opened() const { return opened_; }
  /// No new frame may begin: the server is about to stop, or end() was called.
  bool ending() const { return draining_ || ending_; }
  /// True if a frame may begin now, as far as the upload before it and the credit in frames go.
  bool has_turn() const;
  /// Frames without an answer.
  std::size_t in_flight() const { return sent_.size(); }
  bool holds(std::uint64_t sequence) const;

  enum class Fit { kNow, kLater, kNever };
  /// Whether the credit in bytes has room for so many now, or ever.
  Fit fit(std::uint64_t bytes) const;
  std::uint64_t credit_bytes() const { return credit_.bytes(); }

  /// The next frame. Only if has_turn() and the payload fits. The header's number, cloud, bytes and CRC are set here.
  void begin(std::uint64_t sequence, v1::FrameHeader header, const Payload& payload);
  /// Asks the server to leave the frame; its outcome comes all the same.
  void cancel(std::uint64_t sequence);
  /// No more frames: half-closes when the last upload is done.
  void end() { ending_ = true; }

  /// Fills in the message to be sent next, whatever it held before. Nothing if there is none now.
  struct Sent {
    std::optional<std::uint64_t> sequence;  ///< whose payload it belongs to
    bool completes_payload = false;
  };
  std::optional<Sent> next(Outgoing& outgoing);
  /// True once nothing will be sent any more.
  bool wants_half_close() const;

  /// What a message from the server meant.
  struct Event {
    enum Kind { kNothing, kOpened, kDraining, kBegun, kOutcome } kind = kNothing;
    std::uint64_t sequence = 0;     ///< kBegun, kOutcome
    v1::FrameOutcome outcome = {};  ///< kOutcome: complete, the blocks of the result hold their bytes
    bool intact = true;             ///< kOutcome: false if its checksum differs
  };
  /// An error (INTERNAL) if the server broke the protocol; the connection is of no use then.
  absl::StatusOr<Event> receive(v1::SegmentStreamResponse& message);

 private:
  struct SentFrame {
    std::uint64_t sequence = 0;
    std::uint64_t bytes = 0;
    std::uint64_t points = 0;  // 0: not known
  };
  absl::StatusOr<Event> receive_opened(const v1::StreamOpened& opened);
  absl::StatusOr<Event> receive_outcome(v1::FrameOutcome& outcome);
  absl::StatusOr<Event> receive_chunk(const v1::ResultChunk& chunk);
  Event complete();
  void forget(std::uint64_t number);

  v1::StreamOpen open_;
  bool open_sent_ = false, opened_ = false, draining_ = false, ending_ = false;
  v1::Credit credit_;  // granted
  std::size_t chunk_bytes_ = 0;
  std::uint64_t bytes_used_ = 0;
  std::uint64_t last_number_ = 0;
  std::map<std::uint64_t, SentFrame> sent_;  // by number on the wire
  std::deque<std::uint64_t> cancels_;        // numbers on the wire

  std::uint64_t upload_ = 0;  // number of the frame whose payload is being sent; 0: none
  std::optional<v1::FrameHeader> header_;
  wire::OutgoingBytes payload_;

  std::optional<v1::FrameOutcome> answer_;  // whose bytes are coming
  wire::IncomingBytes answer_bytes_;
};

}  // namespace segserve::client
