#include "server/stream/stream_frame.hpp"

#include <algorithm>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "proto/wire/payload_blocks.hpp"
#include "proto/wire/result_blocks.hpp"
#include "proto/wire/status_message.hpp"

namespace segserve::server {
namespace {

using Clock = StreamFrame::Clock;

Clock::duration to_duration(const google::protobuf::Duration& message) {
  return std::chrono::seconds(message.seconds()) + std::chrono::nanoseconds(message.nanos());
}

absl::Status check_limits(const v1::FrameHeader& header, const codec::DecodeLimits& limits) {
  const std::uint64_t points =
      std::max(header.points(), std::uint64_t{header.cloud().width()} * header.cloud().height());
  if (points > limits.max_points) {
    return wire::limit_exceeded("the cloud has", points, "points", "max_points", limits.max_points);
  }
  if (header.decoded_bytes() > limits.max_bytes) {
    return wire::limit_exceeded("the cloud has", header.decoded_bytes(), "bytes", "max_decoded_bytes",
                                limits.max_bytes);
  }
  return absl::OkStatus();
}

}  // namespace

absl::Status prepare(StreamFrame& frame, const wire::ParsedRequest& defaults, const Options& server_defaults,
                     const codec::DecodeLimits& limits) {
  const v1::FrameHeader& header = frame.header;
  absl::StatusOr<wire::ParsedRequest> parsed = wire::parse_frame(header, defaults, server_defaults);
  if (!parsed.ok()) return parsed.status();
  frame.parsed = *std::move(parsed);
  if (absl::Status status = check_limits(header, limits); !status.ok()) return status;
  frame.payload = wire::IncomingBytes(wire::payload_block_sizes(header.cloud()));
  if (header.has_time_to_live()) {
    frame.expiry = frame.arrival + to_duration(header.time_to_live()) - to_duration(header.age());
  }
  return absl::OkStatus();
}

absl::Status attach_payload(StreamFrame& frame) {
  if (frame.header.has_crc32() && frame.header.crc32() != frame.payload.crc32()) {
    return wire::with_reason(absl::AbortedError("the payload was damaged on its way; send the frame again"),
                             v1::ERROR_REASON_CHECKSUM);
  }
  frame.payload.move_to(wire::payload_blocks(*frame.header.mutable_cloud()));
  return absl::OkStatus();
}

FinishedFrame without_result(const StreamFrame& frame, v1::OutcomeKind kind, const absl::Status& status) {
  FinishedFrame finished;
  v1::FrameOutcome& outcome = finished.outcome;
  outcome.set_sequence(frame.header.sequence());
  outcome.set_request_id(frame.header.request_id());
  outcome.set_frame_id(frame.header.frame_id());
  if (frame.header.has_stamp()) *outcome.mutable_stamp() = frame.header.stamp();
  outcome.set_kind(kind);
  if (!status.ok()) *outcome.mutable_status() = wire::to_message(status);
  finished.credit_bytes = frame.header.encoded_bytes();
  return finished;
}

FinishedFrame with_result(const StreamFrame& frame, v1::SegmentationResult result) {
  FinishedFrame finished = without_result(frame, v1::OUTCOME_KIND_RESULT, absl::OkStatus());
  finished.bytes = wire::OutgoingBytes(std::make_shared<const wire::ByteRun>(wire::result_blocks(result)));
  *finished.outcome.mutable_result() = std::move(result);
  finished.outcome.set_encoded_bytes(finished.bytes.run().size());
  finished.outcome.set_crc32(finished.bytes.run().crc32());
  return finished;
}

}  // namespace segserve::server
