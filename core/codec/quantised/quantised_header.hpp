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

/// The first 40 bytes of a quantised cloud. One zstd frame follows them (core/codec/quantised/FORMAT.md).
struct QuantisedHeader {
  static constexpr std::size_t kBytes = 40;

  std::uint32_t width = 0;
  std::uint32_t height = 0;
  std::uint32_t finite = 0;              ///< number of finite points
  std::array<std::uint8_t, 3> planes{};  ///< bytes of a difference in x, y, z: 1 to 4, or 0 if no point is finite
  bool has_color = false;
  double step = 0;         ///< step of the grid, meters
  double error_bound = 0;  ///< meters

  std::size_t points() const { return std::size_t{width} * height; }
  bool has_bitmap() const { return finite != points(); }
  std::size_t bitmap_bytes() const { return has_bitmap() ? codec::bitmap_bytes(points()) : 0; }
  /// Bytes of the zstd frame's content: the bitmap, the planes of the differences, and the planes of the colors.
  std::size_t body_bytes() const;
};

/// The 40 bytes of a header.
std::string encode_header(const QuantisedHeader& header);

/// Decodes the header at the beginning of `bytes`. The sizes of an accepted header may be allocated. INVALID_ARGUMENT
/// that names the fault or the exceeded limit.
absl::StatusOr<QuantisedHeader> decode_header(std::string_view bytes, const DecodeLimits& limits);

}  // namespace segserve::codec
