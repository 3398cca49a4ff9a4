// SPDX-License-Identifier: Apache-2.0
#include "client/segctl/tiff_image.hpp"

#include <tiffio.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cstdarg>
#include <cstdint>
#include <cstdio>
#include <cstring>
#include <memory>
#include <vector>

#include "core/base/status_macros.hpp"
#include "fmt/format.h"
#include "segserve/codec/decode_limits.hpp"

namespace segserve::segctl {
namespace {

using std::string_view_literals::operator""sv;

absl::Status fault(std::string_view message) { return absl::InvalidArgumentError(fmt::format("TIFF: {}", message)); }

/// A file in memory, as libtiff's functions for files see it.
struct Memory {
  std::string_view bytes;
  std::uint64_t offset = 0;
  std::array<char, 200> error{};  // the first one
};

tmsize_t read_memory(thandle_t handle, void* out, tmsize_t size) {
  auto& memory = *static_cast<Memory*>(handle);
  const std::uint64_t begin = std::min<std::uint64_t>(memory.offset, memory.bytes.size());
  const auto count =
      std::min<std::uint64_t>(static_cast<std::uint64_t>(std::max<tmsize_t>(size, 0)), memory.bytes.size() - begin);
  if (count > 0) std::memcpy(out, memory.bytes.data() + begin, count);
  memory.offset = begin + count;
  return static_cast<tmsize_t>(count);
}

tmsize_t write_nothing(thandle_t /*handle*/, void* /*bytes*/, tmsize_t /*size*/) { return 0; }

toff_t seek_memory(thandle_t handle, toff_t offset, int whence) {
  auto& memory = *static_cast<Memory*>(handle);
  const std::uint64_t base = whence == SEEK_CUR ? memory.offset : whence == SEEK_END ? memory.bytes.size() : 0;
  memory.offset = base + offset;
  return memory.offset;
}

int close_nothing(thandle_t /*handle*/) { return 0; }

toff_t size_of_memory(thandle_t handle) { return static_cast<Memory*>(handle)->bytes.size(); }

int keep_error(TIFF* /*tiff*/, void* user, const char* /*module*/, const char* format, std::va_list arguments) {
  auto& memory = *static_cast<Memory*>(user);
  if (memory.error[0] == '\0') std::vsnprintf(memory.error.data(), memory.error.size(), format, arguments);
  return 1;
}

int ignore_warning(TIFF* /*tiff*/, void* /*user*/, const char* /*module*/, const char* /*format*/,
                   std::va_list /*arguments*/) {
  return 1;
}

struct Close {
  void operator()(TIFF* tiff) const { TIFFClose(tiff); }
};
using Tiff = std::unique_ptr<TIFF, Close>;

Tiff open(Memory& memory) {
  constexpr tmsize_t kMaxAllocation = tmsize_t{1} << 30U;
  const std::unique_ptr<TIFFOpenOptions, decltype(&TIFFOpenOptionsFree)> options(TIFFOpenOptionsAlloc(),
                                                                                 &TIFFOpenOptionsFree);
  TIFFOpenOptionsSetMaxSingleMemAlloc(options.get(), kMaxAllocation);
  TIFFOpenOptionsSetErrorHandlerExtR(options.get(), keep_error, &memory);
  TIFFOpenOptionsSetWarningHandlerExtR(options.get(), ignore_warning, &memory);
  return Tiff(TIFFClientOpenExt("TIFF", "rm", &memory, read_memory, write_nothing, seek_memory, close_nothing,
                                size_of_memory, nullptr, nullptr, options.get()));
}

absl::Status library_fault(const Memory& memory) {
  return fault(memory.error[0] != '\0' ? memory.error.data() : "it cannot be read");
}

/// The layout of the pixels in the file.
struct Layout {
  std::uint32_t width = 0;
  std::uint32_t height = 0;
  std::uint16_t channels = 0;
  std::uint16_t bits = 0;
  std::uint16_t format = 0;  ///< SAMPLEFORMAT_*

  std::size_t pixel_bytes() const { return bits / 8U; }
  std::size_t row_bytes() const { return width * pixel_bytes(); }
};

absl::StatusOr<Layout> read_layout(TIFF* tiff) {
  Layout layout;
  if (TIFFGetField(tiff, TIFFTAG_IMAGEWIDTH, &layout.width) == 0 ||
      TIFFGetField(tiff, TIFFTAG_IMAGELENGTH, &layout.height) == 0 || layout.width == 0 || layout.height == 0) {
    return fault("it does not say how many pixels it has");
  }
  constexpr std::uint64_t kMaxPixels = codec::DecodeLimits{}.max_points;
  if (std::uint64_t{layout.width} * layout.height > kMaxPixels) {
    return fault(fmt::format("{} x {} pixels exceed the limit of {}", layout.width, layout.height, kMaxPixels));
  }
  TIFFGetFieldDefaulted(tiff, TIFFTAG_SAMPLESPERPIXEL, &layout.channels);
  TIFFGetFieldDefaulted(tiff, TIFFTAG_BITSPERSAMPLE, &layout.bits);
  TIFFGetFieldDefaulted(tiff, TIFFTAG_SAMPLEFORMAT, &layout.format);
  return layout;
}

absl::Status check_is_depth(const Layout& layout) {
  if (layout.channels != 1) {
    return fault(
        fmt::format("it has {} channels, but depth has one; are depth and color interchanged?", layout.channels));
  }
  const bool integers = layout.format == SAMPLEFORMAT_UINT && layout.bits == 16;
  const bool floats = layout.format == SAMPLEFORMAT_IEEEFP && (layout.bits == 32 || layout.bits == 64);
  if (integers || floats) return absl::OkStatus();
  const char* kind = layout.format == SAMPLEFORMAT_UINT     ? "unsigned integers"
                     : layout.format == SAMPLEFORMAT_INT    ? "signed integers"
                     : layout.format == SAMPLEFORMAT_IEEEFP ? "floats"
                                                            : "numbers of an unknown kind";
  return fault(
      fmt::format("its pixels are {} of {} bits, but depth must be unsigned integers of 16 bits or floats of "
                  "32 or 64 bits",
                  kind, layout.bits));
}

/// Reads an image of strips, each of which holds some whole rows, to rows from the top.
bool read_strips(TIFF* tiff, const Layout& layout, std::vector<std::byte>& out) {
  std::uint32_t rows = 0;
  TIFFGetFieldDefaulted(tiff, TIFFTAG_ROWSPERSTRIP, &rows);
  if (rows == 0 || TIFFScanlineSize64(tiff) != layout.row_bytes()) return false;
  for (std::uint32_t row = 0, strip = 0; row < layout.height; row += std::min(rows, layout.height - row), ++strip) {
    const std::size_t size = std::min(rows, layout.height - row) * layout.row_bytes();
    const tmsize_t read =
        TIFFReadEncodedStrip(tiff, strip, out.data() + row * layout.row_bytes(), static_cast<tmsize_t>(size));
    if (read != static_cast<tmsize_t>(size)) return false;
  }
  return true;
}

/// Reads an image of tiles, which may reach beyond its right and lower side, to rows from the top.
bool read_tiles(TIFF* tiff, const Layout& layout, std::vector<std::byte>& out) {
  std::uint32_t width = 0, height = 0;
  TIFFGetField(tiff, TIFFTAG_TILEWIDTH, &width);
  TIFFGetField(tiff, TIFFTAG_TILELENGTH, &height);
  constexpr std::uint64_t kMaxTileBytes = std::uint64_t{1} << 29U;
  const std::uint64_t tile_row_bytes = width * layout.pixel_bytes();
  const std::uint64_t tile_bytes = TIFFTileSize64(tiff);
  if (width == 0 || height == 0 || tile_bytes > kMaxTileBytes || tile_bytes != tile_row_bytes * height) return false;
  std::vector<std::byte> tile(tile_bytes);
  for (std::uint32_t top = 0; top < layout.height; top += std::min(height, layout.height - top)) {
    for (std::uint32_t left = 0; left < layout.width; left += std::min(width, layout.width - left)) {
      if (TIFFReadTile(tiff, tile.data(), left, top, 0, 0) != static_cast<tmsize_t>(tile_bytes)) return false;
      const std::size_t part = std::min(width, layout.width - left) * layout.pixel_bytes();
      for (std::uint32_t row = 0; row < std::min(height, layout.height - top); ++row) {
        std::memcpy(out.data() + (top + row) * layout.row_bytes() + left * layout.pixel_bytes(),
                    tile.data() + row * tile_row_bytes, part);
      }
    }
  }
  return true;
}

std::string as_pgm(const Layout& layout, const std::vector<std::byte>& pixels) {
  std::string file = fmt::format("P5\n{} {}\n65535\n", layout.width, layout.height);
  const std::size_t header = file.size();
  file.resize(header + pixels.size());
  for (std::size_t i = 0; i < pixels.size(); i += 2) {  // PGM is big endian.
    std::uint16_t value = 0;
    std::memcpy(&value, pixels.data() + i, sizeof(value));
    file[header + i] = static_cast<char>(value >> 8U);
    file[header + i + 1] = static_cast<char>(value & 0xffU);
  }
  return file;
}

template <typename Float>
std::string as_pfm(const Layout& layout, const std::vector<std::byte>& pixels) {
  static_assert(std::endian::native == std::endian::little);
  std::string file = fmt::format("Pf\n{} {}\n-1\n", layout.width, layout.height);
  const std::size_t header = file.size();
  file.resize(header + sizeof(float) * layout.width * layout.height);
  char* to = file.data() + header;
  for (std::uint32_t row = layout.height; row-- > 0;) {  // The bottom row stands first.
    const std::byte* from = pixels.data() + row * layout.row_bytes();
    for (std::uint32_t i = 0; i < layout.width; ++i, from += sizeof(Float), to += sizeof(float)) {
      Float value = 0;
      std::memcpy(&value, from, sizeof(value));
      const auto narrow = static_cast<float>(value);
      std::memcpy(to, &narrow, sizeof(narrow));
    }
  }
  return file;
}

}  // namespace

bool is_tiff(std::string_view bytes) {
  constexpr std::array kSignatures{"II*\0"sv, "MM\0*"sv, "II+\0"sv, "MM\0+"sv};
  return std::ranges::any_of(kSignatures, [&](std::string_view signature) { return bytes.starts_with(signature); });
}

absl::StatusOr<std::string> depth_from_tiff(std::string_view bytes) {
  Memory memory{bytes};
  const Tiff tiff = open(memory);
  if (!tiff) return library_fault(memory);
  ASSIGN_OR_RETURN(const Layout layout, read_layout(tiff.get()));
  RETURN_IF_ERROR(check_is_depth(layout));
  std::vector<std::byte> pixels(layout.height * layout.row_bytes());
  const bool done =
      TIFFIsTiled(tiff.get()) != 0 ? read_tiles(tiff.get(), layout, pixels) : read_strips(tiff.get(), layout, pixels);
  if (!done) return library_fault(memory);
  if (layout.bits == 16) return as_pgm(layout, pixels);
  return layout.bits == 32 ? as_pfm<float>(layout, pixels) : as_pfm<double>(layout, pixels);
}

absl::StatusOr<std::string> color_from_tiff(std::string_view bytes) {
  Memory memory{bytes};
  const Tiff tiff = open(memory);
  if (!tiff) return library_fault(memory);
  ASSIGN_OR_RETURN(const Layout layout, read_layout(tiff.get()));
  std::vector<std::uint32_t> colors(std::size_t{layout.width} * layout.height);
  constexpr int kStopOnError = 1;
  if (TIFFReadRGBAImageOriented(tiff.get(), layout.width, layout.height, colors.data(), ORIENTATION_TOPLEFT,
                                kStopOnError) == 0) {
    return library_fault(memory);
  }
  std::string file = fmt::format("P6\n{} {}\n255\n", layout.width, layout.height);
  file.reserve(file.size() + 3 * colors.size());
  for (const std::uint32_t color : colors) {
    for (const std::uint32_t channel : {TIFFGetR(color), TIFFGetG(color), TIFFGetB(color)}) {
      file.push_back(static_cast<char>(channel));
    }
  }
  return file;
}

}  // namespace segserve::segctl
