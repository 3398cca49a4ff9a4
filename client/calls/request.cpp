// SPDX-License-Identifier: Apache-2.0
#include "client/calls/request.hpp"

#include <cstdint>
#include <string_view>
#include <utility>

#include "client/calls/payload_data.hpp"
#include "core/base/status_macros.hpp"
#include "proto/wire/codec_message.hpp"
#include "proto/wire/options_message.hpp"
#include "proto/wire/prompts_message.hpp"
#include "proto/wire/request_message.hpp"
#include "proto/wire/status_message.hpp"
#include "proto/wire/track_message.hpp"
#include "proto/wire/transport_limits.hpp"

namespace segserve::client {
namespace {

v1::SegmentRequest request_without_cloud(const Options& options, const CallOptions& call) {
  v1::SegmentRequest request;
  request.set_request_id(call.request_id);
  *request.mutable_options() = wire::to_message(options);
  *request.mutable_outputs() = wire::to_message(call.outputs);
  if (call.prompts) *request.mutable_prompts() = wire::to_message(*call.prompts);
  if (call.tracking) *request.mutable_tracking() = wire::to_message(*call.tracking);
  return request;
}

absl::Status check_size(std::uint64_t bytes, std::string_view what) {
  if (bytes <= wire::kMaxRequestBytes) return absl::OkStatus();
  return wire::limit_exceeded(what, bytes, "bytes", "max_message_bytes", wire::kMaxRequestBytes);
}

/// The size of the planes without compression, which tells early that there is no need to encode them.
std::uint64_t raw_bytes(const CloudView& cloud) {
  return std::uint64_t{cloud.size()} * (3 * sizeof(float) + (cloud.has_color() ? 3 : 0));
}

/// The request with the cloud in this encoding, unless it is too large. `what` begins the message of that error.
absl::StatusOr<v1::SegmentRequest> encode(const CloudView& cloud, wire::CodecOptions codec, const Options& options,
                                          const CallOptions& call, std::string_view what = "the request has") {
  v1::SegmentRequest request = request_without_cloud(options, call);
  ASSIGN_OR_RETURN(*request.mutable_cloud(), wire::to_message(cloud, codec));
  RETURN_IF_ERROR(check_size(request.ByteSizeLong(), what));
  return request;
}

}  // namespace

absl::StatusOr<v1::SegmentRequest> cloud_request(const CloudView& cloud, const Options& options,
                                                 const CallOptions& call) {
  RETURN_IF_ERROR(check_shape(cloud));
  if (call.codec) return encode(cloud, *call.codec, options, call);
  if (call.compress != Compress::kAlways) {
    absl::Status too_large = check_size(raw_bytes(cloud), "the cloud, not compressed, has");
    if (too_large.ok()) {
      auto request = encode(cloud, {.codec = wire::Codec::kPlanar}, options, call);
      if (request.ok()) return request;
      too_large = request.status();
    }
    if (call.compress == Compress::kNever) return too_large;
  }
  return encode(cloud, {.codec = wire::Codec::kPlanarZstd}, options, call,
                "the request, with the cloud compressed, has");
}

absl::StatusOr<v1::SegmentRequest> payload_request(const Payload& payload, const Options& options,
                                                   const CallOptions& call) {
  RETURN_IF_ERROR(check_size(payload.bytes(), "the payload has"));
  v1::SegmentRequest request = request_without_cloud(options, call);
  *request.mutable_cloud() = message_of(payload);
  RETURN_IF_ERROR(check_size(request.ByteSizeLong(), "the request has"));
  return request;
}

}  // namespace segserve::client
