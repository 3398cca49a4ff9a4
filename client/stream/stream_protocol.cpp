// SPDX-License-Identifier: Apache-2.0
#include "client/stream/stream_protocol.hpp"

#include <algorithm>
#include <string>
#include <utility>
#include <vector>

#include "client/calls/payload_data.hpp"
#include "fmt/format.h"
#include "proto/wire/result_blocks.hpp"

namespace segserve::client {
namespace {

using v1::SegmentStreamResponse;

/// The most bytes that the result for a cloud can have: two labels of 4 bytes for each point, a tree in which every
/// point is a leaf of 20 bytes, and some slack for zstd and the columns. `points` is 0 if it is not known; 100 million
/// are allowed then.
constexpr std::uint64_t max_result_bytes(std::uint64_t points) {
  constexpr std::uint64_t kUnknown = 100'000'000, kBytesPerPoint = 28, kSlack = 64 << 10U;
  return kSlack + kBytesPerPoint * (points == 0 ? kUnknown : points);
}

absl::Status broken(std::string message) {
  return absl::InternalError("the server broke the protocol of the stream: " + std::move(message));
}

}  // namespace

StreamProtocol::StreamProtocol(v1::StreamOpen open) : open_(std::move(open)) {}

bool StreamProtocol::has_turn() const {
  return opened_ && !ending() && upload_ == 0 && sent_.size() < credit_.frames();
}

StreamProtocol::Fit StreamProtocol::fit(std::uint64_t bytes) const {
  if (bytes > credit_.bytes()) return Fit::kNever;
  return bytes_used_ + bytes <= credit_.bytes() ? Fit::kNow : Fit::kLater;
}

void StreamProtocol::begin(std::uint64_t sequence, v1::FrameHeader header, const Payload& payload) {
  upload_ = ++last_number_;
  header.set_sequence(upload_);
  *header.mutable_cloud() = payload.data().header;
  header.set_encoded_bytes(payload.bytes());
  header.set_points(payload.points());
  header.set_decoded_bytes(payload.decoded_bytes());
  header.set_crc32(payload.data().run->crc32());
  header_ = std::move(header);
  bytes_used_ += payload.bytes();
  sent_[upload_] = {sequence, payload.bytes(), payload.points()};
  payload_ = wire::OutgoingBytes(payload.data().run);
}

void StreamProtocol::cancel(std::uint64_t sequence) {
  for (const auto& [number, frame] : sent_) {
    if (frame.sequence == sequence) cancels_.push_back(number);
  }
}

std::optional<StreamProtocol::Sent> StreamProtocol::next(OutgoingMessage& outgoing) {
  outgoing.data = {};
  outgoing.owner.reset();
  if (!open_sent_) {
    open_sent_ = true;
    *outgoing.message.mutable_open() = open_;
    return Sent{};
  }
  if (header_) return next_header(outgoing);  // first, so that no cancel comes before the header of its frame
  if (!cancels_.empty()) return next_cancel(outgoing);
  if (upload_ != 0) return next_chunk(outgoing);
  return std::nullopt;
}

StreamProtocol::Sent StreamProtocol::next_header(OutgoingMessage& outgoing) {
  const Sent sent{sent_.at(upload_).sequence, payload_.done()};
  *outgoing.message.mutable_frame() = *std::exchange(header_, std::nullopt);
  if (sent.completes_payload) upload_ = 0;
  return sent;
}

StreamProtocol::Sent StreamProtocol::next_cancel(OutgoingMessage& outgoing) {
  const std::uint64_t number = cancels_.front();
  cancels_.pop_front();
  if (upload_ == number) upload_ = 0;  // no chunks of the frame may follow
  outgoing.message.mutable_cancel()->set_sequence(number);
  return {};
}

StreamProtocol::Sent StreamProtocol::next_chunk(OutgoingMessage& outgoing) {
  outgoing.message.mutable_chunk()->set_sequence(upload_);
  outgoing.data = payload_.next(chunk_bytes_);
  outgoing.owner = payload_.shared_run();
  const Sent sent{sent_.at(upload_).sequence, payload_.done()};
  if (sent.completes_payload) {
    upload_ = 0;
    payload_ = {};  // which may hold a cloud that the application wants back
  }
  return sent;
}

bool StreamProtocol::wants_half_close() const { return ending() && open_sent_ && upload_ == 0 && cancels_.empty(); }

absl::StatusOr<StreamProtocol::Event> StreamProtocol::receive(SegmentStreamResponse& message) {
  if (!opened_ && !message.has_opened()) return broken("its first message was not StreamOpened");
  if (outcome_ && !message.has_chunk()) return broken("another message interrupted the bytes of a result");
  switch (message.kind_case()) {
    case SegmentStreamResponse::kOpened:
      return receive_opened(message.opened());
    case SegmentStreamResponse::kOutcome:
      return receive_outcome(*message.mutable_outcome());
    case SegmentStreamResponse::kChunk:
      return receive_chunk(message.chunk());
    case SegmentStreamResponse::kDraining:
      if (message.draining().reason() == v1::DRAIN_REASON_STREAM_AGE) return Event{.kind = Event::kOld};
      draining_ = true;
      return Event{.kind =
                       message.draining().reason() == v1::DRAIN_REASON_TOKEN ? Event::kTokenOver : Event::kDraining};
    case SegmentStreamResponse::KIND_NOT_SET:
      return Event{};  // a message that a newer version knows
  }
  return Event{};
}

absl::StatusOr<StreamProtocol::Event> StreamProtocol::receive_opened(const v1::StreamOpened& opened) {
  if (opened_) return broken("it opened the stream twice");
  if (opened.credit().frames() == 0 || opened.credit().bytes() == 0 || opened.max_chunk_bytes() == 0) {
    return broken("it granted no credit");
  }
  opened_ = true;
  credit_ = opened.credit();
  chunk_bytes_ = std::min<std::size_t>(opened.max_chunk_bytes(), wire::kMaxChunkBytes);
  return Event{.kind = Event::kOpened};
}

absl::StatusOr<StreamProtocol::Event> StreamProtocol::receive_outcome(v1::FrameOutcome& outcome) {
  const auto frame = sent_.find(outcome.sequence());
  if (frame == sent_.end()) return broken(fmt::format("it ended frame {}, which it does not have", outcome.sequence()));
  if (upload_ == outcome.sequence()) upload_ = 0;  // the server does not want the rest of the payload
  const std::uint64_t most = max_result_bytes(frame->second.points);
  if (outcome.encoded_bytes() > most) {
    return broken(fmt::format("it announced a result of {} bytes; {} are allowed", outcome.encoded_bytes(), most));
  }
  std::vector<std::uint64_t> sizes = wire::result_block_sizes(outcome.result());
  std::uint64_t promised = 0;
  for (const std::uint64_t size : sizes) promised += std::min(size, most);  // does not overflow
  if (promised != outcome.encoded_bytes()) {
    return broken(
        fmt::format("it announced a result of {} bytes whose blocks have {}", outcome.encoded_bytes(), promised));
  }
  outcome_ = std::move(outcome);
  outcome_bytes_ = wire::IncomingBytes(std::move(sizes));
  if (outcome_bytes_.missing() == 0) return complete_outcome();
  return Event{.kind = Event::kBegun, .sequence = frame->second.sequence};
}

absl::StatusOr<StreamProtocol::Event> StreamProtocol::receive_chunk(const v1::ResultChunk& chunk) {
  if (!outcome_ || chunk.sequence() != outcome_->sequence()) return broken("it sent a chunk that belongs to no result");
  if (chunk.data().empty() || !outcome_bytes_.add(chunk.data())) {
    return broken(fmt::format("it sent a chunk of {} bytes where {} were missing", chunk.data().size(),
                              outcome_bytes_.missing()));
  }
  return outcome_bytes_.missing() == 0 ? complete_outcome() : Event{};
}

StreamProtocol::Event StreamProtocol::complete_outcome() {
  Event event{.kind = Event::kOutcome};
  event.outcome = *std::exchange(outcome_, std::nullopt);
  event.sequence = sent_.at(event.outcome.sequence()).sequence;
  event.intact = outcome_bytes_.crc32() == event.outcome.crc32() || event.outcome.encoded_bytes() == 0;
  outcome_bytes_.move_to(wire::result_blocks(*event.outcome.mutable_result()));
  forget(event.outcome.sequence());
  return event;
}

void StreamProtocol::forget(std::uint64_t number) {
  bytes_used_ -= sent_.at(number).bytes;
  sent_.erase(number);
  std::erase(cancels_, number);
}

}  // namespace segserve::client
