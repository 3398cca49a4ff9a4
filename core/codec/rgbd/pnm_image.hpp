// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <bit>
#include <cstdint>
#include <optional>
#include <string_view>

#include "absl/status/statusor.h"
#include "core/base/stop_check.hpp"
#include "core/codec/rgbd/image_pixels.hpp"

// Images of the Netpbm family: PGM (gray), PPM (color), each as text or as bytes, and PFM (floats). Decoders take
// untrusted bytes. They compare the size with the limits and with the bytes at hand before they allocate memory, and
// return INVALID_ARGUMENT for wrong bytes and what `check` says once it is stopped. Bytes after the image are left out.
namespace segserve::codec {

enum class PnmKind : std::uint8_t { kGrayText, kColorText, kGray, kColor, kFloat };

/// The header, which stands before the pixels.
struct PnmHeader {
  PnmKind kind = PnmKind::kGray;
  ImageSize size;
  std::uint32_t max_value = 0;           ///< the number of full brightness, 1 to 65535; 0 for floats
  double scale = 1;                      ///< the amount of the scale of floats
  std::endian order = std::endian::big;  ///< of the pixels' bytes
  std::size_t offset = 0;                ///< of the pixels
};

/// Whether the bytes begin as a file of the family.
bool is_pnm(std::string_view bytes);

/// INVALID_ARGUMENT unless the bytes begin with a header of one of the kinds.
absl::StatusOr<PnmHeader> read_pnm_header(std::string_view bytes);

/// Decodes a PGM. INVALID_ARGUMENT for other kinds, and if its largest value is below 256, as in pictures.
absl::StatusOr<GrayImage> decode_pgm_depth(std::string_view bytes, const DecodeLimits& limits, StopCheck& check);

/// Decodes a gray PFM. Its bottom row stands first. The amount of its scale is not used.
absl::StatusOr<FloatImage> decode_pfm(std::string_view bytes, const DecodeLimits& limits, StopCheck& check);

/// Decodes a PGM or PPM to 8 bits a channel.
absl::StatusOr<ColorImage> decode_pnm_color(std::string_view bytes, const DecodeLimits& limits, StopCheck& check);

}  // namespace segserve::codec
