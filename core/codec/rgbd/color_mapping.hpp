// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "absl/status/statusor.h"
#include "core/codec/rgbd/image_size.hpp"
#include "segserve/codec/rgbd.hpp"

namespace segserve::codec {

/// Which pixel of the color image shows a pixel of the depth image: its column depends on the column alone, its row on
/// the row alone.
struct ColorMapping {
  static constexpr std::uint32_t kOutside = UINT32_MAX;
  std::vector<std::uint32_t> column;  ///< for each column of the depth image, or kOutside
  std::vector<std::uint32_t> row;     ///< for each row of the depth image, or kOutside
};

/// The mapping of decode_rgbd. INVALID_ARGUMENT if the color image has other proportions than the depth image, by more
/// than a pixel, and no intrinsics.
absl::StatusOr<ColorMapping> map_colors(const ImageSize& depth, const ImageSize& color, const Intrinsics& intrinsics,
                                        const std::optional<Intrinsics>& color_intrinsics);

}  // namespace segserve::codec
