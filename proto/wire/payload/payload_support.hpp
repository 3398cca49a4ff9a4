// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <string>
#include <string_view>

#include "absl/status/status.h"
#include "segserve/cloud.hpp"
#include "segserve/codec/decode_limits.hpp"
#include "segserve/v1/cloud.pb.h"

// What the decoders of several payloads have in common.
namespace segserve::wire {

/// What a decoder of segserve::codec found: damage (MALFORMED_PAYLOAD), or a limit of v1.Limits exceeded; that it
/// was stopped stays as it is.
absl::Status decode_error(const absl::Status& status);

/// LIMIT_EXCEEDED unless so many points, and so many bytes of them, are allowed.
absl::Status check_limits(std::uint64_t points, std::uint64_t bytes, const codec::DecodeLimits& limits);

/// INVALID_FIELD if the message says a shape and `what` ("the PCD file") has another one.
absl::Status check_shape_agrees(const v1::Cloud& message, const Cloud& cloud, std::string_view what);

/// A message with the cloud's shape and view.
v1::Cloud message_around(const CloudView& cloud);

/// The rule by which a view was chosen that the request names: for people.
std::string requested_view_rule(const View& view);

}  // namespace segserve::wire
