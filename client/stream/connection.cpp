#include "client/stream/connection.hpp"

#include <algorithm>
#include <utility>
#include <vector>

#include "fmt/format.h"
#include "proto/wire/result_blocks.hpp"

namespace segserve::client {
namespace {

using v1::SegmentStreamResponse;

/// No answer to a cloud has more bytes: two labels of 4 bytes for each point, all of them leaves of a tree with 20
/// bytes for each, and what zstd and the columns add. Of 100 million points, if their number is not known.
constexpr std::uint64_t max_answer_bytes(std::uint64_t points) {
  constexpr std::uint64_t kUnknown = 100'000'000, kBytesPerPoint = 28, kSlack = 64 << 10U;
  return kSlack + kBytesPerPoint * (points == 0 ? kUnknown : points);
}

absl::Status broken(std::string message) {
  return absl::InternalError("the server broke the protocol of the stream: " + std::move(message));
}

}  // namespace

Connection::Connection(v1::StreamOpen open) : open_(std::move(open)) {}

bool Connection::has_turn() const { return opened_ && !ending() && upload_ == 0 && sent_.size() < credit_.frames(); }

bool Connection::holds(std::uint64_t sequence) const {
  return std::ranges::any_of(sent_, [&](const auto& entry) { return entry.second.sequence == sequence; });
}

Connection::Fit Connection::fit(std::uint64_t bytes) const {
  if (bytes > credit_.bytes()) return Fit::kNever;
  return bytes_used_ + bytes <= credit_.bytes() ? Fit::kNow : Fit::kLater;
}

void Connection::begin(std::uint64_t sequence, v1::FrameHeader header, const Payload& payload) {
  upload_ = ++last_number_;
  header.set_sequence(upload_);
  *header.mutable_cloud() = payload.header();
  header.set_encoded_bytes(payload.bytes());
  header.set_points(payload.points());
  header.set_decoded_bytes(payload.decoded_bytes());
  header.set_crc32(payload.run()->crc32());
  header_ = std::move(header);
  bytes_used_ += payload.bytes();
  sent_[upload_] = {sequence, payload.bytes(), payload.points()};
  payload_ = wire::OutgoingBytes(payload.run());
}

void Connection::cancel(std::uint64_t sequence) {
  for (const auto& [number, frame] : sent_) {
    if (frame.sequence == sequence) cancels_.push_back(number);
  }
}

std::optional<Connection::Sent> Connection::next(Outgoing& outgoing) {
  outgoing.data = {};
  outgoing.owner.reset();
  v1::SegmentStreamRequest& message = outgoing.message;
  if (!open_sent_) {
    open_sent_ = true;
    *message.mutable_open() = open_;
    return Sent{};
  }
  if (header_) {  // first, so that no cancel comes before the header of its frame
    const std::uint64_t sequence = sent_.at(upload_).sequence;
    *message.mutable_frame() = *std::exchange(header_, std::nullopt);
    const bool complete = payload_.done();
    if (complete) upload_ = 0;
    return Sent{sequence, complete};
  }
  if (!cancels_.empty()) {
    const std::uint64_t number = cancels_.front();
    cancels_.pop_front();
    if (upload_ == number) upload_ = 0;  // no chunks of it follow
    message.mutable_cancel()->set_sequence(number);
    return Sent{};
  }
  if (upload_ == 0) return std::nullopt;
  const std::uint64_t sequence = sent_.at(upload_).sequence;
  message.mutable_chunk()->set_sequence(upload_);
  outgoing.data = payload_.next(chunk_bytes_);
  outgoing.owner = payload_.shared_run();
  const bool complete = payload_.done();
  if (complete) {
    upload_ = 0;
    payload_ = {};  // which may hold a cloud that the application wants back
  }
  return Sent{sequence, complete};
}

bool Connection::wants_half_close() const { return ending() && open_sent_ && upload_ == 0 && cancels_.empty(); }

absl::StatusOr<Connection::Event> Connection::receive(SegmentStreamResponse& message) {
  if (!opened_ && !message.has_opened()) return broken("its first message was not StreamOpened");
  if (answer_ && !message.has_chunk()) return broken("the bytes of a result were interrupted");
  switch (message.kind_case()) {
    case SegmentStreamResponse::kOpened:
      return receive_opened(message.opened());
    case SegmentStreamResponse::kOutcome:
      return receive_outcome(*message.mutable_outcome());
    case SegmentStreamResponse::kChunk:
      return receive_chunk(message.chunk());
    case SegmentStreamResponse::kDraining:
      draining_ = true;
      return Event{.kind = Event::kDraining};
    case SegmentStreamResponse::KIND_NOT_SET:
      return Event{};  // of a newer version
  }
  return Event{};
}

absl::StatusOr<Connection::Event> Connection::receive_opened(const v1::StreamOpened& opened) {
  if (opened_) return broken("it opened the stream twice");
  if (opened.credit().frames() == 0 || opened.credit().bytes() == 0 || opened.max_chunk_bytes() == 0) {
    return broken("it granted no credit");
  }
  opened_ = true;
  credit_ = opened.credit();
  chunk_bytes_ = std::min<std::size_t>(opened.max_chunk_bytes(), wire::kMaxChunkBytes);
  return Event{.kind = Event::kOpened};
}

absl::StatusOr<Connection::Event> Connection::receive_outcome(v1::FrameOutcome& outcome) {
  const auto frame = sent_.find(outcome.sequence());
  if (frame == sent_.end()) return broken(fmt::format("it ended frame {}, which it does not have", outcome.sequence()));
  if (upload_ == outcome.sequence()) upload_ = 0;  // the rest is not wanted
  const std::uint64_t most = max_answer_bytes(frame->second.points);
  if (outcome.encoded_bytes() > most) {
    return broken(fmt::format("a result of {} bytes; {} are allowed", outcome.encoded_bytes(), most));
  }
  std::vector<std::uint64_t> sizes = wire::result_block_sizes(outcome.result());
  std::uint64_t promised = 0;
  for (const std::uint64_t size : sizes) promised += std::min(size, most);
  if (promised != outcome.encoded_bytes()) {
    return broken(fmt::format("a result of {} bytes with blocks of {}", outcome.encoded_bytes(), promised));
  }
  answer_ = std::move(outcome);
  answer_bytes_ = wire::IncomingBytes(std::move(sizes));
  if (answer_bytes_.missing() == 0) return complete();
  return Event{.kind = Event::kBegun, .sequence = frame->second.sequence};
}

absl::StatusOr<Connection::Event> Connection::receive_chunk(const v1::ResultChunk& chunk) {
  if (!answer_ || chunk.sequence() != answer_->sequence()) return broken("a chunk of no result");
  if (chunk.data().empty() || !answer_bytes_.add(chunk.data())) {
    return broken(
        fmt::format("a chunk of {} bytes, where {} are missing", chunk.data().size(), answer_bytes_.missing()));
  }
  return answer_bytes_.missing() == 0 ? complete() : Event{};
}

Connection::Event Connection::complete() {
  Event event{.kind = Event::kOutcome};
  event.outcome = *std::exchange(answer_, std::nullopt);
  event.sequence = sent_.at(event.outcome.sequence()).sequence;
  event.intact = answer_bytes_.crc32() == event.outcome.crc32() || event.outcome.encoded_bytes() == 0;
  answer_bytes_.move_to(wire::result_blocks(*event.outcome.mutable_result()));
  forget(event.outcome.sequence());
  return event;
}

void Connection::forget(std::uint64_t number) {
  bytes_used_ -= sent_.at(number).bytes;
  sent_.erase(number);
  std::erase(cancels_, number);
}

}  // namespace segserve::client
