// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "absl/status/statusor.h"

namespace segserve::codec {

/// Labels, ids or counts as unsigned little-endian integers, all of the same width.
struct EncodedIntegers {
  std::string bytes;
  std::uint32_t bytes_per_value = 1;  ///< 1, 2 or 4: the smallest that holds the largest value
};

EncodedIntegers encode_integers(std::span<const std::uint32_t> values);

/// INVALID_ARGUMENT if `bytes_per_value` is not 1, 2 or 4, or `bytes` does not hold whole values.
absl::StatusOr<std::vector<std::uint32_t>> decode_integers(std::string_view bytes, std::uint32_t bytes_per_value);

}  // namespace segserve::codec
