// SPDX-License-Identifier: Apache-2.0
#include "core/codec/rgbd/depth_image.hpp"

#include <fmt/format.h>

#include <array>

#include "core/base/status_macros.hpp"
#include "core/codec/file/known_formats.hpp"
#include "core/codec/npy/npy_header.hpp"
#include "core/codec/rgbd/jpeg_image.hpp"
#include "core/codec/rgbd/npy_depth.hpp"
#include "core/codec/rgbd/png_image.hpp"
#include "core/codec/rgbd/pnm_image.hpp"
#include "segserve/codec/rgbd.hpp"

namespace segserve::codec {
namespace {

constexpr std::uint64_t kPointBytes = 16;  // A decoded point has 3 floats and a color.

bool is_tiff(std::string_view bytes) {
  constexpr std::array<std::string_view, 4> kSignatures{std::string_view("II*\0", 4), std::string_view("MM\0*", 4),
                                                        std::string_view("II+\0", 4), std::string_view("MM\0+", 4)};
  for (const std::string_view signature : kSignatures) {
    if (bytes.starts_with(signature)) return true;
  }
  return false;
}

absl::Status unknown_format(std::string_view bytes) {
  if (is_jpeg(bytes)) {
    return absl::InvalidArgumentError(
        "a JPEG cannot hold depth, because it has 8 bits and loses some; a PNG, PGM or TIFF of 16 bits can");
  }
  if (is_tiff(bytes)) {
    return absl::InvalidArgumentError("TIFF is not read here, only by segctl; send a PNG, PGM or PFM file");
  }
  if (const std::string_view name = format_name(bytes); !name.empty()) {
    return absl::InvalidArgumentError(
        fmt::format("this is {}, which is not read as depth; a PNG of 16 bits, PGM, PFM or NPY is", name));
  }
  return absl::InvalidArgumentError("the bytes are neither PNG nor PGM nor PFM nor NPY");
}

}  // namespace

absl::StatusOr<DepthFormat> depth_format(std::string_view depth) {
  if (is_png(depth)) {
    ASSIGN_OR_RETURN(const ImageSize size, png_size(depth));
    return DepthFormat{.width = size.width, .height = size.height};
  }
  if (is_npy(depth)) return npy_depth_format(depth);
  if (!is_pnm(depth)) return unknown_format(depth);
  ASSIGN_OR_RETURN(const PnmHeader header, read_pnm_header(depth));
  return DepthFormat{header.size.width, header.size.height, header.kind == PnmKind::kFloat, header.scale};
}

absl::StatusOr<DepthImage> decode_depth(std::string_view bytes, const DecodeLimits& limits, StopCheck& check) {
  ASSIGN_OR_RETURN(const DepthFormat format, depth_format(bytes));
  RETURN_IF_ERROR(check_image_size({format.width, format.height}, kPointBytes, limits));
  if (is_png(bytes)) return decode_png_depth(bytes, limits, check);
  if (is_npy(bytes)) return decode_npy_depth(bytes, limits, check);
  if (format.floats) return decode_pfm(bytes, limits, check);
  return decode_pgm_depth(bytes, limits, check);
}

}  // namespace segserve::codec
