// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <string_view>

#include "absl/status/status.h"
#include "segserve/codec/decode_limits.hpp"

// Checks of claimed sizes against DecodeLimits. Each returns a status of over_limit if the claim is too large. Messages
// begin with `prefix`, such as "Draco: ", which may be empty.
namespace segserve::codec {

/// a * b, or the largest 64-bit number if the product does not fit.
constexpr std::uint64_t saturating_product(std::uint64_t a, std::uint64_t b) {
  return b != 0 && a > UINT64_MAX / b ? UINT64_MAX : a * b;
}

/// a + b, or the largest 64-bit number if the sum does not fit.
constexpr std::uint64_t saturating_sum(std::uint64_t a, std::uint64_t b) {
  return a > UINT64_MAX - b ? UINT64_MAX : a + b;
}

/// Checks the number of points of a cloud against max_points.
absl::Status check_points(std::string_view prefix, std::uint64_t points, const DecodeLimits& limits);

/// Checks the bytes of `points` decoded points against max_bytes.
absl::Status check_decoded_points(std::string_view prefix, std::uint64_t points, std::uint64_t bytes_per_point,
                                  const DecodeLimits& limits);

/// Checks the bytes of an encoded cloud, or of what was decompressed from it, against max_bytes.
absl::Status check_bytes(std::string_view prefix, std::uint64_t bytes, const DecodeLimits& limits);

}  // namespace segserve::codec
