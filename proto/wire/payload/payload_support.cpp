// SPDX-License-Identifier: Apache-2.0
#include "proto/wire/payload/payload_support.hpp"

#include <optional>
#include <utility>

#include "fmt/format.h"
#include "proto/wire/cloud_message.hpp"
#include "proto/wire/status_message.hpp"

namespace segserve::wire {

absl::Status decode_error(const absl::Status& status) {
  if (absl::IsCancelled(status) || absl::IsDeadlineExceeded(status)) return status;
  const std::optional<codec::LimitExcess> excess = codec::limit_excess(status);
  if (!excess) return with_reason(status, ErrorReason::kMalformedPayload);
  return with_details(absl::Status(status.code(), status.message()),
                      {.reason = ErrorReason::kLimitExceeded,
                       .metadata = {{"limit", excess->limit == "max_bytes" ? "max_decoded_bytes" : excess->limit},
                                    {"allowed", fmt::format("{}", excess->allowed)},
                                    {"actual", fmt::format("{}", excess->actual)}}});
}

DecodedCloud decoded_cloud(codec::LabeledCloud&& decoded) {
  return {std::move(decoded.cloud), std::move(decoded.view_rule), std::move(decoded.warnings), decoded.placement};
}

std::uint64_t points_of_shape(const v1::Cloud& message) { return std::uint64_t{message.width()} * message.height(); }

absl::Status check_limits(std::uint64_t points, std::uint64_t bytes, const codec::DecodeLimits& limits) {
  if (points > limits.max_points) {
    return limit_exceeded("the cloud has", points, "points", "max_points", limits.max_points);
  }
  if (bytes > limits.max_bytes) {
    return limit_exceeded("the cloud decodes to", bytes, "bytes", "max_decoded_bytes", limits.max_bytes);
  }
  return absl::OkStatus();
}

absl::Status check_shape_agrees(const v1::Cloud& message, const Cloud& cloud, std::string_view source) {
  const bool shape_is_given = message.width() != 0 || message.height() != 0;
  if (!shape_is_given || (message.width() == cloud.width && message.height() == cloud.height)) return absl::OkStatus();
  return invalid_fields({{"cloud.width", fmt::format("the message says {} x {}, but {} has {} x {}", message.width(),
                                                     message.height(), source, cloud.width, cloud.height)}});
}

v1::Cloud message_without_payload(const CloudView& cloud) {
  v1::Cloud message;
  message.set_width(cloud.width);
  message.set_height(cloud.height);
  *message.mutable_view() = to_message(cloud.view);
  return message;
}

std::string requested_view_rule(const View& view) {
  return fmt::format("{} as the request says", view.kind == ViewKind::kCamera ? "CAMERA" : "WORLD");
}

}  // namespace segserve::wire
