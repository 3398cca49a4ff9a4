// SPDX-License-Identifier: Apache-2.0
#include "server/frames/frame_resolver.hpp"

#include <algorithm>
#include <chrono>
#include <utility>

#include "core/base/status_macros.hpp"
#include "proto/wire/codec_message.hpp"
#include "proto/wire/request_message.hpp"
#include "proto/wire/status_message.hpp"

namespace segserve::server {
namespace {

FrameSettings::Time::duration to_duration(const google::protobuf::Duration& message) {
  return std::chrono::seconds(message.seconds()) + std::chrono::nanoseconds(message.nanos());
}

std::optional<FrameSettings::Time> end_of_life(const v1::FrameHeader& header, FrameSettings::Time arrival) {
  if (!header.has_time_to_live()) return std::nullopt;
  return arrival + to_duration(header.time_to_live()) - to_duration(header.age());
}

std::uint64_t points_of_shape(const v1::Cloud& cloud) { return std::uint64_t{cloud.width()} * cloud.height(); }

/// Points of a cloud that says nothing about its shape, judged by the bytes of its payload.
std::uint64_t points_of_bytes(std::uint64_t bytes) {
  constexpr std::uint64_t kTypicalBytesPerPoint = 16;
  return bytes / kTypicalBytesPerPoint;
}

}  // namespace

codec::DecodeLimits decode_limits(const ServerOptions& options) {
  return {.max_points = options.max_points, .max_bytes = options.max_decoded_bytes, .draco = options.enable_draco};
}

FrameResolver::FrameResolver(const ServerOptions& options)
    : default_options_(options.defaults),
      max_threads_(options.threads),
      max_frame_time_(options.max_frame_time),
      decode_limits_(segserve::server::decode_limits(options)) {}

absl::StatusOr<FrameSettings> FrameResolver::resolve_call(const v1::SegmentRequest& request, Time arrival,
                                                          std::optional<Time> deadline) const {
  ASSIGN_OR_RETURN(wire::ParsedRequest parsed, wire::parse_request(request, default_options_));
  const v1::Cloud& cloud = request.cloud();
  const std::uint64_t claimed = points_of_shape(cloud);
  RETURN_IF_ERROR(check_kind_and_claims(cloud, claimed, 0));
  const std::uint64_t estimate = claimed != 0 ? claimed : points_of_bytes(cloud.ByteSizeLong());
  return settings(parsed, arrival, deadline, estimate);
}

FrameSettings FrameResolver::resolve_file(wire::ParsedRequest request, std::uint64_t bytes, Time arrival,
                                          std::optional<Time> deadline) const {
  return settings(std::move(request), arrival, deadline, points_of_bytes(bytes));
}

absl::StatusOr<wire::ParsedRequest> FrameResolver::resolve_stream(const v1::StreamOpen& open) const {
  return wire::parse_open(open, default_options_);
}

absl::StatusOr<FrameSettings> FrameResolver::resolve_frame(const v1::FrameHeader& header,
                                                           const wire::ParsedRequest& stream, Time arrival) const {
  ASSIGN_OR_RETURN(wire::ParsedRequest parsed, wire::parse_frame(header, stream, default_options_));
  const std::uint64_t claimed = std::max(header.points(), points_of_shape(header.cloud()));
  RETURN_IF_ERROR(check_kind_and_claims(header.cloud(), claimed, header.decoded_bytes()));
  const std::uint64_t estimate = claimed != 0 ? claimed : points_of_bytes(header.encoded_bytes());
  return settings(parsed, arrival, end_of_life(header, arrival), estimate);
}

absl::Status FrameResolver::check_kind_and_claims(const v1::Cloud& cloud, std::uint64_t points,
                                                  std::uint64_t decoded_bytes) const {
  RETURN_IF_ERROR(wire::check_kind(cloud, decode_limits_));
  if (points > decode_limits_.max_points) {
    return wire::limit_exceeded("the cloud has", points, "points", "max_points", decode_limits_.max_points);
  }
  if (decoded_bytes > decode_limits_.max_bytes) {
    return wire::limit_exceeded("the cloud has", decoded_bytes, "bytes", "max_decoded_bytes", decode_limits_.max_bytes);
  }
  return absl::OkStatus();
}

FrameSettings FrameResolver::settings(wire::ParsedRequest request, Time arrival, std::optional<Time> deadline,
                                      std::uint64_t estimated_points) const {
  request.options.threads = std::min(request.options.threads, max_threads_);
  return {.options = request.options,
          .outputs = request.outputs,
          .prompts = std::move(request.prompts),
          .tracking = std::move(request.tracking),
          .decode_limits = decode_limits_,
          .arrival = arrival,
          .deadline = deadline,
          .max_time = max_frame_time_,
          .estimated_points = std::min(estimated_points, decode_limits_.max_points)};
}

}  // namespace segserve::server
