// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <span>
#include <string_view>
#include <vector>

#include "absl/status/statusor.h"
#include "segserve/v1/result.pb.h"

namespace segserve::wire {

/// The message of these values, each of which takes as few bytes as the largest of them needs. INTERNAL if Zstandard
/// fails.
absl::StatusOr<v1::IntegerArray> to_message(std::span<const std::uint32_t> values, v1::Compression compression);

/// The values of a message that must hold exactly `count` values, none above `maximum`. INVALID_ARGUMENT,
/// MALFORMED_PAYLOAD if the message holds anything else; the error message begins with `name`.
absl::StatusOr<std::vector<std::uint32_t>> from_message(const v1::IntegerArray& message, std::uint64_t count,
                                                        std::uint32_t maximum, std::string_view name);

}  // namespace segserve::wire
