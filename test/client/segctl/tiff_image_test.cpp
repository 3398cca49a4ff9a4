// SPDX-License-Identifier: Apache-2.0
#include "client/segctl/tiff_image.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <tiffio.h>

#include <cstdint>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <sstream>
#include <string>
#include <vector>

#include "test/temporary_path.hpp"

namespace segserve::segctl {
namespace {

using testing::HasSubstr;

/// The kind of pixels in a TIFF file, and the way in which they are stored.
struct Kind {
  std::uint16_t channels = 1;
  std::uint16_t bits = 16;
  std::uint16_t format = SAMPLEFORMAT_UINT;
  std::uint16_t compression = COMPRESSION_NONE;
  std::uint32_t tile = 0;   ///< side of the tiles; 0: strips
  const char* mode = "wl";  ///< of libtiff: l is little endian, b big endian, 8 BigTIFF
};

constexpr std::uint32_t kWidth = 20, kHeight = 9;

/// The pixels of tile rows that may reach beyond the image.
template <typename Number>
std::vector<Number> tile_at(const std::vector<Number>& pixels, std::uint32_t left, std::uint32_t top,
                            std::uint32_t side) {
  std::vector<Number> tile(std::size_t{side} * side);
  for (std::uint32_t v = 0; v < side && top + v < kHeight; ++v) {
    for (std::uint32_t u = 0; u < side && left + u < kWidth; ++u) {
      tile[v * side + u] = pixels[(top + v) * kWidth + left + u];
    }
  }
  return tile;
}

/// A file of kWidth x kHeight pixels, as libtiff writes it.
template <typename Number>
std::string tiff_file(std::vector<Number> pixels, const Kind& kind) {
  const std::string path = test::temporary_path("image.tif");
  TIFF* tiff = TIFFOpen(path.c_str(), kind.mode);
  TIFFSetField(tiff, TIFFTAG_IMAGEWIDTH, kWidth);
  TIFFSetField(tiff, TIFFTAG_IMAGELENGTH, kHeight);
  TIFFSetField(tiff, TIFFTAG_SAMPLESPERPIXEL, kind.channels);
  TIFFSetField(tiff, TIFFTAG_BITSPERSAMPLE, kind.bits);
  TIFFSetField(tiff, TIFFTAG_SAMPLEFORMAT, kind.format);
  TIFFSetField(tiff, TIFFTAG_COMPRESSION, kind.compression);
  TIFFSetField(tiff, TIFFTAG_PLANARCONFIG, PLANARCONFIG_CONTIG);
  TIFFSetField(tiff, TIFFTAG_PHOTOMETRIC, kind.channels == 3 ? PHOTOMETRIC_RGB : PHOTOMETRIC_MINISBLACK);
  if (kind.tile != 0) {
    TIFFSetField(tiff, TIFFTAG_TILEWIDTH, kind.tile);
    TIFFSetField(tiff, TIFFTAG_TILELENGTH, kind.tile);
    for (std::uint32_t top = 0; top < kHeight; top += kind.tile) {
      for (std::uint32_t left = 0; left < kWidth; left += kind.tile) {
        std::vector<Number> tile = tile_at(pixels, left, top, kind.tile);
        TIFFWriteTile(tiff, tile.data(), left, top, 0, 0);
      }
    }
  } else {
    TIFFSetField(tiff, TIFFTAG_ROWSPERSTRIP, 4U);  // the last strip is shorter
    for (std::uint32_t row = 0; row < kHeight; ++row) {
      TIFFWriteScanline(tiff, pixels.data() + row * kWidth * kind.channels, row, 0);
    }
  }
  TIFFClose(tiff);
  std::ostringstream bytes;
  bytes << std::ifstream(path, std::ios::binary).rdbuf();
  std::filesystem::remove(path);
  return bytes.str();
}

template <typename Number>
std::vector<Number> numbers(std::size_t count, double step) {
  std::vector<Number> result;
  for (std::size_t i = 0; i < count; ++i) result.push_back(static_cast<Number>(step * static_cast<double>(i)));
  return result;
}

constexpr std::size_t kPixels = std::size_t{kWidth} * kHeight;

std::string pgm_of(const std::vector<std::uint16_t>& pixels) {
  std::string file = "P5\n20 9\n65535\n";
  for (const std::uint16_t value : pixels) {
    file.push_back(static_cast<char>(value >> 8U));
    file.push_back(static_cast<char>(value & 0xffU));
  }
  return file;
}

template <typename Float>
std::string pfm_of(const std::vector<Float>& pixels) {
  std::string file = "Pf\n20 9\n-1\n";
  for (std::size_t row = kHeight; row-- > 0;) {
    for (std::size_t i = 0; i < kWidth; ++i) {
      const auto value = static_cast<float>(pixels[row * kWidth + i]);
      file.append(reinterpret_cast<const char*>(&value), sizeof(value));
    }
  }
  return file;
}

TEST(TiffImage, IntegersBecomePgmHoweverTheyAreStored) {
  const auto pixels = numbers<std::uint16_t>(kPixels, 357);
  for (const Kind& kind : {Kind{}, Kind{.mode = "wb"}, Kind{.mode = "w8"}, Kind{.compression = COMPRESSION_LZW},
                           Kind{.compression = COMPRESSION_ADOBE_DEFLATE}, Kind{.tile = 16},
                           Kind{.compression = COMPRESSION_LZW, .tile = 16, .mode = "wb"}}) {
    const std::string file = tiff_file(pixels, kind);
    EXPECT_TRUE(is_tiff(file));
    const auto pgm = depth_from_tiff(file);
    ASSERT_TRUE(pgm.ok()) << pgm.status();
    EXPECT_EQ(*pgm, pgm_of(pixels)) << kind.mode << kind.compression << " " << kind.tile;
  }
}

TEST(TiffImage, FloatsBecomePfm) {
  const auto floats = numbers<float>(kPixels, 0.01);
  for (const Kind& kind :
       {Kind{.bits = 32, .format = SAMPLEFORMAT_IEEEFP}, Kind{.bits = 32, .format = SAMPLEFORMAT_IEEEFP, .mode = "wb"},
        Kind{.bits = 32, .format = SAMPLEFORMAT_IEEEFP, .compression = COMPRESSION_LZW, .tile = 16}}) {
    const auto pfm = depth_from_tiff(tiff_file(floats, kind));
    ASSERT_TRUE(pfm.ok()) << pfm.status();
    EXPECT_EQ(*pfm, pfm_of(floats));
  }
  const auto doubles = numbers<double>(kPixels, 0.01);
  EXPECT_EQ(depth_from_tiff(tiff_file(doubles, {.bits = 64, .format = SAMPLEFORMAT_IEEEFP})).value(), pfm_of(doubles));
}

TEST(TiffImage, ColorsBecomePpm) {
  const auto rgb = numbers<std::uint8_t>(3 * kPixels, 0.4);
  const auto ppm = color_from_tiff(tiff_file(rgb, {.channels = 3, .bits = 8, .compression = COMPRESSION_LZW}));
  ASSERT_TRUE(ppm.ok()) << ppm.status();
  EXPECT_EQ(*ppm, "P6\n20 9\n255\n" + std::string(rgb.begin(), rgb.end()));
}

TEST(TiffImage, OtherPixelsAreRefusedInWordsThatHelp) {
  EXPECT_THAT(depth_from_tiff(tiff_file(numbers<std::uint8_t>(kPixels, 1), {.bits = 8})).status().message(),
              HasSubstr("TIFF: its pixels are unsigned integers of 8 bits, but depth must be"));
  EXPECT_THAT(
      depth_from_tiff(tiff_file(numbers<std::int16_t>(kPixels, 1), {.format = SAMPLEFORMAT_INT})).status().message(),
      HasSubstr("signed integers of 16 bits"));
  EXPECT_THAT(depth_from_tiff(tiff_file(numbers<std::uint8_t>(3 * kPixels, 0.4), {.channels = 3, .bits = 8}))
                  .status()
                  .message(),
              HasSubstr("TIFF: it has 3 channels, but depth has one"));
}

TEST(TiffImage, DamageIsRefusedOrRead) {
  for (const Kind& kind : {Kind{}, Kind{.compression = COMPRESSION_ADOBE_DEFLATE, .tile = 16}}) {
    const std::string good = tiff_file(numbers<std::uint16_t>(kPixels, 1), kind);
    for (std::size_t size = 0; size < good.size(); size += 3) {
      const auto cut = depth_from_tiff(std::string(good.data(), size));
      EXPECT_TRUE(cut.ok() || absl::IsInvalidArgument(cut.status())) << size;
    }
    for (std::size_t at = 0; at < good.size(); ++at) {
      std::string damaged = good;
      damaged[at] = static_cast<char>(~damaged[at]);
      const auto depth = depth_from_tiff(damaged), color = color_from_tiff(damaged);
      EXPECT_TRUE(depth.ok() || absl::IsInvalidArgument(depth.status())) << at;
      EXPECT_TRUE(color.ok() || absl::IsInvalidArgument(color.status())) << at;
    }
  }
  EXPECT_FALSE(is_tiff("II"));
  EXPECT_TRUE(absl::IsInvalidArgument(depth_from_tiff(std::string("II*\0", 4)).status()));
}

TEST(TiffImage, LyingSizesAreRefusedBeforeAllocation) {
  std::string file = tiff_file(numbers<std::uint16_t>(kPixels, 1), {});
  // The entry of the width (tag 256, one number of 16 bits, 20) gets a number of 32 bits.
  const std::size_t width = file.find(std::string("\0\1\3\0\1\0\0\0\x14\0", 10));
  ASSERT_NE(width, std::string::npos);
  file[width + 2] = 4;
  for (std::size_t i = 8; i < 11; ++i) file[width + i] = '\x7f';
  EXPECT_THAT(depth_from_tiff(file).status().message(), HasSubstr("pixels exceed the limit of 64000000"));
  EXPECT_THAT(color_from_tiff(file).status().message(), HasSubstr("pixels exceed the limit of 64000000"));
}

}  // namespace
}  // namespace segserve::segctl
