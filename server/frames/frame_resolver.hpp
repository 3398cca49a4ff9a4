// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>
#include <optional>

#include "absl/status/statusor.h"
#include "proto/wire/request_message.hpp"
#include "segserve/codec/decode_limits.hpp"
#include "segserve/v1/segmentation_service.pb.h"
#include "segserve/v1/stream.pb.h"
#include "server/frames/frame_settings.hpp"
#include "server/options/server_options.hpp"

namespace segserve::server {

/// The limits of what this server decodes. GetServerInfo advertises them, and FrameResolver gives them to every frame.
codec::DecodeLimits decode_limits(const ServerOptions& options);

/// The only place where the settings of frames come from: it joins what a request says, what its stream says, and what
/// this server allows. Everything that can be known before the payload is there is checked here, with equal errors for
/// unary calls and streams: INVALID_ARGUMENT with INVALID_FIELD, which names every wrong field, or LIMIT_EXCEEDED.
class FrameResolver {
 public:
  using Time = FrameSettings::Time;

  explicit FrameResolver(const ServerOptions& options);

  /// Settings of a unary call.
  absl::StatusOr<FrameSettings> resolve_call(const v1::SegmentRequest& request, Time arrival,
                                             std::optional<Time> deadline) const;

  /// Settings of a frame whose request and payload, of so many bytes, are no messages of the API. `request` is valid.
  FrameSettings resolve_file(wire::ParsedRequest request, std::uint64_t bytes, Time arrival,
                             std::optional<Time> deadline) const;

  /// How a call is segmented that sets no options.
  const Options& default_options() const { return default_options_; }

  /// Resolves the parameters of those frames of this stream that do not bring their own.
  absl::StatusOr<wire::ParsedRequest> resolve_stream(const v1::StreamOpen& open) const;

  /// Settings of a frame of a stream. A frame's own options go on top of the server's defaults; its deadline is the end
  /// of its time to live.
  absl::StatusOr<FrameSettings> resolve_frame(const v1::FrameHeader& header, const wire::ParsedRequest& stream,
                                              Time arrival) const;

 private:
  absl::Status check_kind_and_claims(const v1::Cloud& cloud, std::uint64_t points, std::uint64_t decoded_bytes) const;
  FrameSettings settings(wire::ParsedRequest request, Time arrival, std::optional<Time> deadline,
                         std::uint64_t estimated_points) const;

  Options default_options_;
  std::uint32_t max_threads_;
  std::chrono::milliseconds max_frame_time_;
  codec::DecodeLimits decode_limits_;
};

}  // namespace segserve::server
