// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>

#include "absl/status/statusor.h"
#include "core/codec/common/finite_point_mask.hpp"
#include "segserve/codec/decode_limits.hpp"

namespace segserve::codec {

/// The first 40 bytes of a quantised cloud; what follows is one zstd frame (QUANTISED.md).
struct QuantisedHeader {
  static constexpr std::size_t kBytes = 40;

  std::uint32_t width = 0;
  std::uint32_t height = 0;
  std::uint32_t finite = 0;              ///< points
  std::array<std::uint8_t, 3> planes{};  ///< bytes of a difference in x, y, z: 1 to 4; 0 if there is no finite point
  bool has_color = false;
  double step = 0;         ///< of the grid, meters
  double error_bound = 0;  ///< meters

  std::size_t points() const { return std::size_t{width} * height; }
  bool has_bitmap() const { return finite != points(); }
  std::size_t bitmap_bytes() const { return has_bitmap() ? codec::bitmap_bytes(points()) : 0; }
  /// Of the zstd frame's content: bitmap, planes of the differences, planes of the colors.
  std::size_t body_bytes() const;
};

std::string encode_header(const QuantisedHeader& header);

/// INVALID_ARGUMENT for anything that cannot be the beginning of a good quantised cloud, or exceeds the limits: when it
/// is accepted, its sizes may be allocated.
absl::StatusOr<QuantisedHeader> decode_header(std::string_view bytes, const DecodeLimits& limits);

}  // namespace segserve::codec
