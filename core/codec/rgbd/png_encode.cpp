// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>
#include <png.h>

#include <csetjmp>
#include <cstring>

#include "core/codec/rgbd/png_image.hpp"

namespace segserve::codec {
namespace {

// The lowest level is enough, because most of what compression gains on depth comes from the filter.
constexpr int kCompressionLevel = 1;
constexpr int kFilter = PNG_FILTER_SUB;

/// Returns false if there is no memory.
bool append(std::string& out, png_bytep data, std::size_t size) {
  try {
    out.append(reinterpret_cast<const char*>(data), size);
    return true;
  } catch (const std::exception&) {  // An exception must not pass through libpng's stack frames.
    return false;
  }
}

void write_bytes(png_structp png, png_bytep data, std::size_t size) {
  if (!append(*static_cast<std::string*>(png_get_io_ptr(png)), data, size)) png_error(png, "out of memory");
}

void flush(png_structp /*png*/) {}

[[noreturn]] void jump_on_error(png_structp png, png_const_charp /*message*/) { png_longjmp(png, 1); }
void ignore_warning(png_structp /*png*/, png_const_charp /*message*/) {}

/// Writes the image to `out`, or returns false. Nothing in here may have a destructor, because libpng's errors jump out
/// of it.
bool write_rows(std::string& out, const ImageSize& size, const std::uint16_t* pixels) {
  png_structp png = png_create_write_struct(PNG_LIBPNG_VER_STRING, nullptr, jump_on_error, ignore_warning);
  png_infop info = png == nullptr ? nullptr : png_create_info_struct(png);
  if (info == nullptr) {
    png_destroy_write_struct(&png, nullptr);
    return false;
  }
  if (setjmp(png_jmpbuf(png)) != 0) {  // NOLINT(cert-err52-cpp): libpng reports errors so.
    png_destroy_write_struct(&png, &info);
    return false;
  }
  png_set_write_fn(png, &out, write_bytes, flush);
  png_set_IHDR(png, info, size.width, size.height, 16, PNG_COLOR_TYPE_GRAY, PNG_INTERLACE_NONE,
               PNG_COMPRESSION_TYPE_DEFAULT, PNG_FILTER_TYPE_DEFAULT);
  png_set_compression_level(png, kCompressionLevel);
  png_set_filter(png, 0, kFilter);
  png_write_info(png, info);
  png_set_swap(png);  // PNG is big endian.
  for (std::uint32_t row = 0; row < size.height; ++row) {
    png_write_row(png, reinterpret_cast<png_const_bytep>(pixels + std::size_t{row} * size.width));
  }
  png_write_end(png, info);
  png_destroy_write_struct(&png, &info);
  return true;
}

}  // namespace

absl::StatusOr<std::string> encode_png_gray16(const ImageSize& size, std::span<const std::uint16_t> pixels) {
  std::string bytes;
  if (write_rows(bytes, size, pixels.data())) return bytes;
  return absl::InternalError(fmt::format("PNG: {} x {} pixels cannot be written", size.width, size.height));
}

}  // namespace segserve::codec
