// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

#include "absl/status/status.h"
#include "segserve/codec/decode_limits.hpp"

namespace segserve::codec {

/// What an image says of its size before it is decoded.
struct ImageSize {
  std::uint32_t width = 0;
  std::uint32_t height = 0;

  std::uint64_t pixels() const { return std::uint64_t{width} * height; }
  bool operator==(const ImageSize&) const = default;
};

/// INVALID_ARGUMENT if it has more pixels than `limits.max_points`, or more bytes of `bytes_per_pixel` than
/// `limits.max_bytes`.
absl::Status check_image_size(const ImageSize& size, std::uint64_t bytes_per_pixel, const DecodeLimits& limits);

}  // namespace segserve::codec
