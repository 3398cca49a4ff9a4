// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <string_view>

#include "absl/status/status.h"
#include "segserve/v1/server_info.pb.h"
#include "segserve/v1/stream.pb.h"
#include "segserve/wire/error_details.hpp"
#include "server/frames/frame_work.hpp"

// The records of the frames and streams of a server once they are over. Logs, metrics and traces are made from these
// records and from nothing else.
namespace segserve::server {

/// Who made a call. The client chose `client_name` and `traceparent`, which may hold any bytes.
struct Caller {
  std::string peer = {};         ///< gRPC's name of the other end, e.g. "ipv4:192.0.2.7:40312"
  std::string subject = {};      ///< who the caller has proved to be; empty if the server asks for no proof
  std::string client_name = {};  ///< of a stream: StreamOpen.client_name
  std::string traceparent = {};  ///< the call's metadata of this name, not parsed yet; at most kMostTraceparentBytes
};

inline constexpr std::size_t kMostTraceparentBytes = 256;

/// The facts that a status tells, as the client sees it.
struct StatusFacts {
  absl::StatusCode code = absl::StatusCode::kOk;
  wire::ErrorReason reason = wire::ErrorReason::kUnspecified;
  std::string limit = {};  ///< the name of the limit that stood in the way, e.g. "max_queue"; empty if none did
  std::string message = {};
};

/// One frame, from its arrival to its end: a unary call of Segment, or a frame of a stream.
struct FrameRecord {
  using Time = FrameWork::Time;
  enum class Call : std::uint8_t { kUnary, kStream };

  Call call = Call::kStream;
  std::shared_ptr<const Caller> caller = nullptr;  ///< never null
  std::string request_id;      ///< the client chose it; at most 256 bytes unless the frame failed because of it
  std::string traceparent;     ///< of the frame's header, or else of its call; not parsed; may be empty
  std::uint64_t sequence = 0;  ///< within its stream
  v1::PayloadKind payload_kind = v1::PAYLOAD_KIND_UNSPECIFIED;
  std::uint64_t received_bytes = 0;  ///< of all messages about the frame: the request, or the header and chunks
  std::uint64_t sent_bytes = 0;      ///< of all messages of the answer that were handed to gRPC

  Time arrival;                  ///< of the unary request, or of the frame's header
  std::optional<Time> uploaded;  ///< the payload was complete; in a unary call, at the arrival
  std::optional<Time> queued;    ///< it began to wait for a worker
  FrameWork work;                ///< on the worker
  Time decided;                  ///< its outcome was known
  /// The last byte of outcome and result was handed to gRPC; unset if the call ended before.
  std::optional<Time> delivered;

  /// How the frame ended. A unary call is CANCELLED or EXPIRED if its status is CANCELLED or DEADLINE_EXCEEDED. A frame
  /// whose call ended before its outcome was delivered is CANCELLED or FAILED, as the status of the call says.
  v1::OutcomeKind outcome = v1::OUTCOME_KIND_UNSPECIFIED;
  StatusFacts status;       ///< OK unless the frame failed or its call ended before
  bool is_evicted = false;  ///< it made way for another client in the queue
};

/// One call of SegmentStream.
struct StreamRecord {
  using Time = FrameWork::Time;

  std::shared_ptr<const Caller> caller = nullptr;  ///< never null
  Time began{}, ended{};
  bool is_opened = false;    ///< the server answered StreamOpened; false for a stream that was refused
  std::uint64_t frames = 0;  ///< headers that came
  StatusFacts status = {};   ///< OK if the client closed the stream
};

/// A call that asks about the server, of GetServerInfo or of reflection, and was refused.
struct RefusedQuestion {
  std::string_view rpc;                            ///< "GetServerInfo" or "ServerReflectionInfo"
  std::shared_ptr<const Caller> caller = nullptr;  ///< never null
  StatusFacts status = {};
};

/// The status as its client sees it. Without memory for more, only the code is set.
StatusFacts facts_of(const absl::Status& status) noexcept;

/// The record of a unary call that has just come.
FrameRecord arriving_call(Caller caller, FrameRecord::Time now);

/// A unary call ended with this status. Sets what is known from then on.
void end_call(FrameRecord& frame, const absl::Status& status, FrameRecord::Time now) noexcept;

/// The stream of the frame ended with this status before the frame's outcome was delivered. Sets `outcome` and
/// `status`, and `decided` if the frame had no outcome yet.
void end_with_stream(FrameRecord& frame, const absl::Status& status, FrameRecord::Time now) noexcept;

}  // namespace segserve::server
