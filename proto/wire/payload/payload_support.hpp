// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <string>
#include <string_view>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "proto/wire/cloud_message.hpp"
#include "segserve/cloud.hpp"
#include "segserve/codec/decode_limits.hpp"
#include "segserve/codec/labeled_cloud.hpp"
#include "segserve/v1/cloud.pb.h"

// Functions that several kinds of payload share.
namespace segserve::wire {

/// Gives the error of a decoder of segserve::codec its reason: LIMIT_EXCEEDED with the limit of v1.Limits, or else
/// MALFORMED_PAYLOAD. CANCELLED and DEADLINE_EXCEEDED stay as they are.
absl::Status decode_error(const absl::Status& status);

/// Passes on what a decoder of segserve::codec returned, with the reason of decode_error if it is an error.
template <typename Decoded>
absl::StatusOr<Decoded> with_decode_reason(absl::StatusOr<Decoded> decoded) {
  if (!decoded.ok()) return decode_error(decoded.status());
  return decoded;
}

/// Converts the result of codec::decode_pcd and others into this layer's type.
DecodedCloud decoded_cloud(codec::LabeledCloud&& decoded);

/// The number of points of the shape that the message gives, which cannot overflow.
std::uint64_t points_of_shape(const v1::Cloud& message);

/// LIMIT_EXCEEDED if a cloud of this many points, or of this many bytes after decompression, is not allowed.
absl::Status check_limits(std::uint64_t points, std::uint64_t bytes, const codec::DecodeLimits& limits);

/// INVALID_FIELD if the message gives a shape and the decoded cloud has another one. `source` is what the error message
/// calls the payload, e.g. "the PCD file".
absl::Status check_shape_agrees(const v1::Cloud& message, const Cloud& cloud, std::string_view source);

/// A message with the shape and view of the cloud, but without a payload.
v1::Cloud message_without_payload(const CloudView& cloud);

/// The view rule of a cloud whose request gives the view: one line for people.
std::string requested_view_rule(const View& view);

}  // namespace segserve::wire
