// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>
#include <png.h>

#include <algorithm>
#include <array>
#include <csetjmp>
#include <cstring>

#include "core/codec/common/scalar_type.hpp"
#include "core/codec/rgbd/png_image.hpp"

namespace segserve::codec {
namespace {

constexpr std::string_view kSignature("\x89PNG\r\n\x1a\n", 8);
/// Signature, length and name of IHDR, its 13 bytes.
constexpr std::size_t kHeaderBytes = 8 + 4 + 4 + 13;
constexpr std::uint32_t kMaxSide = 0x7fffffff;
/// Of an ancillary chunk: we need none of them.
constexpr png_alloc_size_t kMaxChunkBytes = std::size_t{1} << 20U;

absl::Status fault(std::string_view message) { return absl::InvalidArgumentError(fmt::format("PNG: {}", message)); }

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
    return fault(fmt::format("{} x {} pixels are no size of an image", width, height));
  }
  return header;
}

/// What libpng's callbacks know. Its error function jumps over frames, so nothing between it and setjmp may have a
/// destructor.
struct Source {
  const char* at;
  std::size_t left;
  std::array<char, 160> error;
};

void read_bytes(png_structp png, png_bytep out, std::size_t size) {
  auto* source = static_cast<Source*>(png_get_io_ptr(png));
  if (size > source->left) png_error(png, "the bytes end too early");
  std::memcpy(out, source->at, size);
  source->at += size;
  source->left -= size;
}

[[noreturn]] void keep_error(png_structp png, png_const_charp message) {
  auto* source = static_cast<Source*>(png_get_error_ptr(png));
  std::strncpy(source->error.data(), message, source->error.size() - 1);
  png_longjmp(png, 1);
}

void ignore_warning(png_structp /*png*/, png_const_charp /*message*/) {}

enum class Format : std::uint8_t { kGray16, kColor };

void set_transforms(png_structp png, Format format) {
  if (format == Format::kGray16) {
    png_set_swap(png);  // to little endian
    return;
  }
  png_set_expand(png);
  png_set_strip_16(png);
  png_set_strip_alpha(png);
  png_set_gray_to_rgb(png);
}

/// Decodes into `out`, which has room for `height` rows of `row_bytes`. False with source.error set if it cannot be
/// done.
bool decode_rows(Source& source, Format format, std::uint32_t height, std::size_t row_bytes, png_bytep out) {
  png_structp png = png_create_read_struct(PNG_LIBPNG_VER_STRING, &source, keep_error, ignore_warning);
  png_infop info = png == nullptr ? nullptr : png_create_info_struct(png);
  if (info == nullptr) {
    png_destroy_read_struct(&png, nullptr, nullptr);
    std::strncpy(source.error.data(), "out of memory", source.error.size() - 1);
    return false;
  }
  if (setjmp(png_jmpbuf(png)) != 0) {  // NOLINT(cert-err52-cpp): libpng's way to tell errors
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
  if (png_get_rowbytes(png, info) != row_bytes) png_error(png, "its rows have another size than its header says");
  for (int pass = 0; pass < passes; ++pass) {
    for (std::uint32_t row = 0; row < height; ++row) png_read_row(png, out + row * row_bytes, nullptr);
  }
  png_read_end(png, nullptr);
  png_destroy_read_struct(&png, &info, nullptr);
  return true;
}

absl::Status decode(std::string_view bytes, Format format, const ImageSize& size, std::size_t row_bytes, void* out) {
  Source source{bytes.data(), bytes.size(), {}};
  if (decode_rows(source, format, size.height, row_bytes, static_cast<png_bytep>(out))) return absl::OkStatus();
  return fault(source.error.data());
}

}  // namespace

bool is_png(std::string_view bytes) { return bytes.starts_with(kSignature); }

absl::StatusOr<ImageSize> png_size(std::string_view bytes) {
  const auto header = read_header(bytes);
  if (!header.ok()) return header.status();
  return header->size;
}

absl::StatusOr<GrayImage> decode_png_gray16(std::string_view bytes, const DecodeLimits& limits) {
  const auto header = read_header(bytes);
  if (!header.ok()) return header.status();
  if (header->color_type != PNG_COLOR_TYPE_GRAY || header->bit_depth != 16) {
    return fault(fmt::format("color type {} with {} bits; needed is gray (0) with 16 bits", header->color_type,
                             header->bit_depth));
  }
  constexpr std::size_t kPixelBytes = sizeof(std::uint16_t);
  if (absl::Status status = check_image_size(header->size, kPixelBytes, limits); !status.ok()) return status;
  GrayImage image{header->size, std::vector<std::uint16_t>(header->size.pixels())};
  absl::Status status = decode(bytes, Format::kGray16, image.size, image.size.width * kPixelBytes, image.pixels.data());
  if (!status.ok()) return status;
  return image;
}

absl::StatusOr<ColorImage> decode_png_color(std::string_view bytes, const DecodeLimits& limits) {
  const auto header = read_header(bytes);
  if (!header.ok()) return header.status();
  constexpr std::size_t kPixelBytes = 3;
  if (absl::Status status = check_image_size(header->size, kPixelBytes, limits); !status.ok()) return status;
  ColorImage image{header->size, std::vector<std::uint8_t>(kPixelBytes * header->size.pixels())};
  absl::Status status = decode(bytes, Format::kColor, image.size, image.size.width * kPixelBytes, image.rgb.data());
  if (!status.ok()) return status;
  return image;
}

}  // namespace segserve::codec
