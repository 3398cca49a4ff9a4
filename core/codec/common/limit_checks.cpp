// SPDX-License-Identifier: Apache-2.0
#include "core/codec/common/limit_checks.hpp"

#include <fmt/format.h>

namespace segserve::codec {

absl::Status check_points(std::string_view prefix, std::uint64_t points, const DecodeLimits& limits) {
  if (points <= limits.max_points) return absl::OkStatus();
  return over_limit(fmt::format("{}{} points exceed the limit of {} points", prefix, points, limits.max_points),
                    {"max_points", points, limits.max_points});
}

absl::Status check_decoded_points(std::string_view prefix, std::uint64_t points, std::uint64_t bytes_per_point,
                                  const DecodeLimits& limits) {
  if (points <= limits.max_bytes / bytes_per_point) return absl::OkStatus();
  return over_limit(fmt::format("{}{} points of {} bytes exceed the limit of {} bytes", prefix, points, bytes_per_point,
                                limits.max_bytes),
                    {"max_bytes", saturating_product(points, bytes_per_point), limits.max_bytes});
}

absl::Status check_bytes(std::string_view prefix, std::uint64_t bytes, const DecodeLimits& limits) {
  if (bytes <= limits.max_bytes) return absl::OkStatus();
  return over_limit(fmt::format("{}{} bytes exceed the limit of {} bytes", prefix, bytes, limits.max_bytes),
                    {"max_bytes", bytes, limits.max_bytes});
}

}  // namespace segserve::codec
