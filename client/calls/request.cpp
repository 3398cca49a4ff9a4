#include "client/calls/request.hpp"

#include <cstdint>
#include <string_view>
#include <utility>

#include "proto/wire/codec_message.hpp"
#include "proto/wire/options_message.hpp"
#include "proto/wire/status_message.hpp"
#include "proto/wire/transport_limits.hpp"

namespace segserve::client {
namespace {

v1::SegmentRequest request_without_cloud(const Options& options, const CallOptions& call) {
  v1::SegmentRequest request;
  request.set_request_id(call.request_id);
  *request.mutable_options() = wire::to_message(options);
  *request.mutable_outputs() = wire::to_message(call.outputs);
  return request;
}

absl::Status check_size(std::uint64_t bytes, std::string_view what) {
  if (bytes <= wire::kMaxRequestBytes) return absl::OkStatus();
  return wire::limit_exceeded(what, bytes, "bytes", "max_message_bytes", wire::kMaxRequestBytes);
}

/// The request if it is not too large.
absl::StatusOr<v1::SegmentRequest> checked(absl::StatusOr<v1::SegmentRequest> request, std::string_view what) {
  if (!request.ok()) return request;
  if (absl::Status size = check_size(request->ByteSizeLong(), what); !size.ok()) return size;
  return request;
}

/// Bytes of the planes without compression: tells early that there is no need to try.
std::uint64_t raw_bytes(const CloudView& cloud) {
  return std::uint64_t{cloud.size()} * (3 * sizeof(float) + (cloud.has_color() ? 3 : 0));
}

absl::StatusOr<v1::SegmentRequest> encode(const CloudView& cloud, const wire::CodecOptions& codec,
                                          const Options& options, const CallOptions& call) {
  absl::StatusOr<v1::Cloud> message = wire::to_message(cloud, codec);
  if (!message.ok()) return message.status();
  v1::SegmentRequest request = request_without_cloud(options, call);
  *request.mutable_cloud() = *std::move(message);
  return request;
}

}  // namespace

absl::StatusOr<v1::SegmentRequest> cloud_request(const CloudView& cloud, const Options& options,
                                                 const CallOptions& call) {
  if (absl::Status status = check_shape(cloud); !status.ok()) return status;
  if (call.codec) return checked(encode(cloud, *call.codec, options, call), "the request has");
  if (call.compress != Compress::kAlways) {
    absl::Status raw = check_size(raw_bytes(cloud), "the cloud, not compressed, has");
    if (raw.ok()) {
      auto request = checked(encode(cloud, {.codec = wire::Codec::kPlanar}, options, call), "the request has");
      if (request.ok()) return request;
      raw = request.status();
    }
    if (call.compress == Compress::kNever) return raw;
  }
  return checked(encode(cloud, {.codec = wire::Codec::kPlanarZstd}, options, call),
                 "the request, with the cloud compressed, has");
}

absl::StatusOr<v1::SegmentRequest> payload_request(const Payload& payload, const Options& options,
                                                   const CallOptions& call) {
  if (absl::Status size = check_size(payload.bytes(), "the payload has"); !size.ok()) return size;
  v1::SegmentRequest request = request_without_cloud(options, call);
  *request.mutable_cloud() = payload.message();
  return checked(std::move(request), "the request has");
}

}  // namespace segserve::client
