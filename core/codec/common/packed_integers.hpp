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

/// Labels, ids or counts as unsigned little-endian integers that all have the same width.
struct EncodedIntegers {
  std::string bytes;
  std::uint32_t bytes_per_value = 1;  ///< 1, 2 or 4
};

/// Encodes the values with the smallest width that holds the largest of them.
EncodedIntegers encode_integers(std::span<const std::uint32_t> values);

/// Decodes all values of `bytes`. INVALID_ARGUMENT if `bytes_per_value` is not 1, 2 or 4, or the values do not fill
/// `bytes` exactly.
absl::StatusOr<std::vector<std::uint32_t>> decode_integers(std::string_view bytes, std::uint32_t bytes_per_value);

}  // namespace segserve::codec
