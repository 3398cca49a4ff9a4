// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

#include "absl/status/status.h"
#include "segserve/codec/decode_limits.hpp"

namespace segserve::codec {

/// The size that an image file claims, in pixels.
struct ImageSize {
  std::uint32_t width = 0;
  std::uint32_t height = 0;

  std::uint64_t pixels() const { return std::uint64_t{width} * height; }
  bool operator==(const ImageSize&) const = default;
};

/// Checks the pixels against `limits.max_points`, and their bytes against `limits.max_bytes`. INVALID_ARGUMENT, as
/// over_limit makes it, if a limit is exceeded.
absl::Status check_image_size(const ImageSize& size, std::uint64_t bytes_per_pixel, const DecodeLimits& limits);

}  // namespace segserve::codec
