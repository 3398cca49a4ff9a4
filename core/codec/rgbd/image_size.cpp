// SPDX-License-Identifier: Apache-2.0
#include "core/codec/rgbd/image_size.hpp"

#include <fmt/format.h>

#include "core/codec/common/limit_checks.hpp"

namespace segserve::codec {

absl::Status check_image_size(const ImageSize& size, std::uint64_t bytes_per_pixel, const DecodeLimits& limits) {
  const std::uint64_t pixels = size.pixels();
  if (pixels > limits.max_points) {
    return over_limit(
        fmt::format("{} x {} pixels exceed the limit of {} points", size.width, size.height, limits.max_points),
        {"max_points", pixels, limits.max_points});
  }
  if (pixels > limits.max_bytes / bytes_per_pixel) {
    return over_limit(fmt::format("{} x {} pixels of {} bytes exceed the limit of {} bytes", size.width, size.height,
                                  bytes_per_pixel, limits.max_bytes),
                      {"max_bytes", saturating_product(pixels, bytes_per_pixel), limits.max_bytes});
  }
  return absl::OkStatus();
}

}  // namespace segserve::codec
