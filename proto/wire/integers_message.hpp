// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <span>
#include <string_view>
#include <vector>

#include "absl/status/statusor.h"
#include "segserve/v1/result.pb.h"

namespace segserve::wire {

/// The values with as few bytes each as the largest of them needs.
absl::StatusOr<v1::IntegerArray> to_message(std::span<const std::uint32_t> values, v1::Compression compression);

/// Exactly `count` values, all of them at most `maximum`; the caller has checked `count` against its limits.
/// MALFORMED_PAYLOAD, naming the array by `name`, if the message holds anything else.
absl::StatusOr<std::vector<std::uint32_t>> from_message(const v1::IntegerArray& message, std::uint64_t count,
                                                        std::uint32_t maximum, std::string_view name);

}  // namespace segserve::wire
