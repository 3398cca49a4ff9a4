// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>
#include <png.h>

#include <algorithm>
#include <array>
#include <csetjmp>
#include <cstring>

#include "core/base/status_macros.hpp"
#include "core/codec/common/scalar_type.hpp"
#include "core/codec/rgbd/png_image.hpp"

namespace segserve::codec {
namespace {

constexpr std::string_view kSignature("\x89PNG\r\n\x1a\n", 8);
/// The signature, the length and the name of IHDR, and its 13 bytes.
constexpr std::size_t kHeaderBytes = 8 + 4 + 4 + 13;
constexpr std::uint32_t kMaxSide = 0x7fffffff;
/// The most memory that libpng allocates for an ancillary chunk. The decoders need none of these chunks.
constexpr png_alloc_size_t kMaxChunkBytes = std::size_t{1} << 20U;

absl::Status fault(std::string_view message) { return absl::InvalidArgumentError(fmt::format("PNG: {}", message)); }

/// The claims of the first chunk (IHDR).
struct PngHeader {
  ImageSize size;
  unsigned bit_depth = 0;
  unsigned color_type = 0;
};

absl::StatusOr<PngHeader> read_header(std::string_view bytes) {
  if (!is_png(bytes)) return fault("the bytes do not begin with a PNG signature");
  if (bytes.size() < kHeaderBytes || bytes.substr(12, 4) != "IHDR") return fault("it does not begin with IHDR");
  const auto* ihdr = reinterpret_cast<const std::byte*>(bytes.data()) + 16;
  PngHeader header;
  header.size.width = load<std::uint32_t>(ihdr, std::endian::big);
  header.size.height = load<std::uint32_t>(ihdr + 4, std::endian::big);
  header.bit_depth = load<std::uint8_t>(ihdr + 8);
  header.color_type = load<std::uint8_t>(ihdr + 9);
  const auto [width, height] = header.size;
  if (width == 0 || height == 0 || width > kMaxSide || height > kMaxSide) {
    return fault(fmt::format("{} x {} pixels are not the size of an image", width, height));
  }
  return header;
}

/// The state of libpng's callbacks. keep_error jumps over stack frames, so nothing between it and setjmp may have a
/// destructor.
struct Source {
  const char* at;               ///< the next byte
  std::size_t left;             ///< bytes from `at` on
  StopCheck* check;             ///< counts the pixels, and what is read: an image may have chunks without end
  std::array<char, 160> error;  ///< the message of the last error
};

void read_bytes(png_structp png, png_bytep out, std::size_t size) {
  auto* source = static_cast<Source*>(png_get_io_ptr(png));
  if (size > source->left) png_error(png, "the bytes end too early");
  std::memcpy(out, source->at, size);
  source->at += size;
  source->left -= size;
  constexpr std::size_t kBytesPerUnit = 16;
  if (source->check->after(1 + size / kBytesPerUnit)) png_longjmp(png, 1);
}

[[noreturn]] void keep_error(png_structp png, png_const_charp message) {
  auto* source = static_cast<Source*>(png_get_error_ptr(png));
  std::strncpy(source->error.data(), message, source->error.size() - 1);
  png_longjmp(png, 1);
}

void ignore_warning(png_structp /*png*/, png_const_charp /*message*/) {}

/// The pixels that are decoded: gray of 16 bits, or R, G, B of 8 bits.
enum class Format : std::uint8_t { kGray16, kColor };

void set_transforms(png_structp png, Format format) {
  if (format == Format::kGray16) {
    png_set_swap(png);  // PNG is big endian.
    return;
  }
  png_set_expand(png);
  png_set_strip_16(png);
  png_set_strip_alpha(png);
  png_set_gray_to_rgb(png);
}

/// Decodes into `out`, which has space for `size.height` rows of `row_bytes`. Returns false if that fails, with
/// source.error set, or if it is stopped.
bool decode_rows(Source& source, Format format, const ImageSize& size, std::size_t row_bytes, png_bytep out) {
  png_structp png = png_create_read_struct(PNG_LIBPNG_VER_STRING, &source, keep_error, ignore_warning);
  png_infop info = png == nullptr ? nullptr : png_create_info_struct(png);
  if (info == nullptr) {
    png_destroy_read_struct(&png, nullptr, nullptr);
    std::strncpy(source.error.data(), "out of memory", source.error.size() - 1);
    return false;
  }
  if (setjmp(png_jmpbuf(png)) != 0) {  // NOLINT(cert-err52-cpp): libpng reports errors so.
    png_destroy_read_struct(&png, &info, nullptr);
    return false;
  }
  png_set_read_fn(png, &source, read_bytes);
  png_set_user_limits(png, kMaxSide, kMaxSide);
  png_set_chunk_malloc_max(png, kMaxChunkBytes);
  png_set_keep_unknown_chunks(png, PNG_HANDLE_CHUNK_NEVER, nullptr, -1);
  png_read_info(png, info);
  set_transforms(png, format);
  const int passes = png_set_interlace_handling(png);
  png_read_update_info(png, info);
  if (png_get_rowbytes(png, info) != row_bytes) png_error(png, "its rows have another size than its header claims");
  for (int pass = 0; pass < passes; ++pass) {
    for (std::uint32_t row = 0; row < size.height; ++row) {
      if (source.check->after(size.width)) png_longjmp(png, 1);
      png_read_row(png, out + row * row_bytes, nullptr);
    }
  }
  png_read_end(png, nullptr);
  png_destroy_read_struct(&png, &info, nullptr);
  return true;
}

/// Decodes the pixels to `out`, which has space for size.height rows of `row_bytes`.
absl::Status decode(std::string_view bytes, Format format, const ImageSize& size, std::size_t row_bytes,
                    StopCheck& check, void* out) {
  Source source{bytes.data(), bytes.size(), &check, {}};
  if (decode_rows(source, format, size, row_bytes, static_cast<png_bytep>(out))) return check.status();
  if (check.stopped()) return check.status();
  return fault(source.error.data());
}

/// Why a PNG is no depth image.
absl::Status check_is_depth(const PngHeader& header) {
  const char* kind = "a color image";
  if (header.color_type == PNG_COLOR_TYPE_GRAY) {
    if (header.bit_depth == 16) return absl::OkStatus();
    return fault(
        fmt::format("it is gray with {} bits, but depth needs 16: this is a picture of a depth image, which has lost "
                    "the distances; write the depth itself, as gray with 16 bits",
                    header.bit_depth));
  }
  if (header.color_type == PNG_COLOR_TYPE_GRAY_ALPHA) kind = "a gray image with an alpha channel";
  if (header.color_type == PNG_COLOR_TYPE_PALETTE) kind = "an image with a palette";
  return fault(
      fmt::format("it is {} with {} bits, but depth must be gray with 16 bits and without alpha; are depth and "
                  "color interchanged?",
                  kind, header.bit_depth));
}

}  // namespace

bool is_png(std::string_view bytes) { return bytes.starts_with(kSignature); }

absl::StatusOr<ImageSize> png_size(std::string_view bytes) {
  ASSIGN_OR_RETURN(const PngHeader header, read_header(bytes));
  return header.size;
}

absl::StatusOr<GrayImage> decode_png_depth(std::string_view bytes, const DecodeLimits& limits, StopCheck& check) {
  ASSIGN_OR_RETURN(const PngHeader header, read_header(bytes));
  RETURN_IF_ERROR(check_is_depth(header));
  constexpr std::size_t kPixelBytes = sizeof(std::uint16_t);
  RETURN_IF_ERROR(check_image_size(header.size, kPixelBytes, limits));
  GrayImage image{header.size, std::vector<std::uint16_t>(header.size.pixels())};
  RETURN_IF_ERROR(
      decode(bytes, Format::kGray16, image.size, image.size.width * kPixelBytes, check, image.pixels.data()));
  return image;
}

absl::StatusOr<ColorImage> decode_png_color(std::string_view bytes, const DecodeLimits& limits, StopCheck& check) {
  ASSIGN_OR_RETURN(const PngHeader header, read_header(bytes));
  constexpr std::size_t kPixelBytes = 3;
  RETURN_IF_ERROR(check_image_size(header.size, kPixelBytes, limits));
  ColorImage image{header.size, std::vector<std::uint8_t>(kPixelBytes * header.size.pixels())};
  RETURN_IF_ERROR(decode(bytes, Format::kColor, image.size, image.size.width * kPixelBytes, check, image.rgb.data()));
  return image;
}

}  // namespace segserve::codec
