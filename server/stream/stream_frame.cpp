// SPDX-License-Identifier: Apache-2.0
#include "server/stream/stream_frame.hpp"

#include <utility>

#include "proto/wire/codec_message.hpp"
#include "proto/wire/payload_blocks.hpp"
#include "proto/wire/result_blocks.hpp"
#include "proto/wire/status_message.hpp"

namespace segserve::server {

StreamFrame::StreamFrame(v1::FrameHeader frame_header, Time arrival) : header(std::move(frame_header)) {
  record.call = FrameRecord::Call::kStream;
  record.request_id = header.request_id();
  record.sequence = header.sequence();
  record.payload_kind = wire::kind_of(header.cloud());
  record.arrival = arrival;
}

absl::Status attach_payload(StreamFrame& frame) {
  if (frame.header.has_crc32() && frame.header.crc32() != frame.payload.crc32()) {
    return wire::with_reason(absl::AbortedError("the payload was damaged on its way; send the frame again"),
                             wire::ErrorReason::kChecksum);
  }
  frame.payload.move_to(wire::payload_blocks(*frame.header.mutable_cloud()));
  return absl::OkStatus();
}

FinishedFrame outcome_without_result(const StreamFrame& frame, v1::OutcomeKind kind, const absl::Status& status) {
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

FinishedFrame outcome_with_result(const StreamFrame& frame, v1::SegmentationResult result) {
  FinishedFrame finished = outcome_without_result(frame, v1::OUTCOME_KIND_RESULT, absl::OkStatus());
  finished.bytes = wire::OutgoingBytes(std::make_shared<const wire::ByteRun>(wire::result_blocks(result)));
  *finished.outcome.mutable_result() = std::move(result);
  finished.outcome.set_encoded_bytes(finished.bytes.run().size());
  finished.outcome.set_crc32(finished.bytes.run().crc32());
  return finished;
}

}  // namespace segserve::server
