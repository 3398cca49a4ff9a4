// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <gtest/gtest.h>
#include <png.h>

#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <string>
#include <vector>

// jpeglib.h needs what stands above.
#include <jpeglib.h>

#include "core/base/stop_check.hpp"
#include "core/codec/rgbd/image_pixels.hpp"
#include "segserve/stop_token.hpp"

// Image files as other programs write them.
namespace segserve::codec {

/// A check that nobody stops.
struct GoOn {
  StopToken stop;
  StopCheck check{stop};
};

/// A PNG in any of libpng's simple formats, with its colormap if the format has one.
inline std::string png_file(std::uint32_t width, std::uint32_t height, png_uint_32 format, const void* pixels,
                            const void* colormap = nullptr, png_uint_32 colors = 0) {
  png_image image{};
  image.version = PNG_IMAGE_VERSION;
  image.width = width;
  image.height = height;
  image.format = format;
  image.colormap_entries = colors;
  png_alloc_size_t size = 0;
  EXPECT_NE(png_image_write_to_memory(&image, nullptr, &size, 0, pixels, 0, colormap), 0);
  std::string bytes(size, '\0');
  EXPECT_NE(png_image_write_to_memory(&image, bytes.data(), &size, 0, pixels, 0, colormap), 0);
  bytes.resize(size);
  return bytes;
}

/// How jpeg_file writes.
struct JpegKind {
  J_COLOR_SPACE pixels = JCS_RGB;    ///< what the pixels are
  J_COLOR_SPACE stored = JCS_YCbCr;  ///< what the file stores
  bool adobe = false;                ///< whether it has Adobe's marker
  bool progressive = false;
};

/// A JPEG of quality 95 without subsampling.
inline std::string jpeg_file(const ImageSize& size, std::vector<std::uint8_t> pixels, const JpegKind& kind = {}) {
  jpeg_compress_struct jpeg{};
  jpeg_error_mgr errors{};
  jpeg.err = jpeg_std_error(&errors);
  jpeg_create_compress(&jpeg);
  unsigned char* bytes = nullptr;
  unsigned long count = 0;
  jpeg_mem_dest(&jpeg, &bytes, &count);
  jpeg.image_width = size.width;
  jpeg.image_height = size.height;
  jpeg.input_components = static_cast<int>(pixels.size() / size.pixels());
  jpeg.in_color_space = kind.pixels;
  jpeg_set_defaults(&jpeg);
  jpeg_set_colorspace(&jpeg, kind.stored);
  for (int i = 0; i < jpeg.num_components; ++i) jpeg.comp_info[i].h_samp_factor = jpeg.comp_info[i].v_samp_factor = 1;
  jpeg.write_Adobe_marker = kind.adobe ? TRUE : FALSE;
  jpeg_set_quality(&jpeg, 95, TRUE);
  if (kind.progressive) jpeg_simple_progression(&jpeg);
  jpeg_start_compress(&jpeg, TRUE);
  while (jpeg.next_scanline < jpeg.image_height) {
    JSAMPROW row = pixels.data() + jpeg.next_scanline * (pixels.size() / size.height);
    jpeg_write_scanlines(&jpeg, &row, 1);
  }
  jpeg_finish_compress(&jpeg);
  jpeg_destroy_compress(&jpeg);
  std::string file(reinterpret_cast<const char*>(bytes), count);
  std::free(bytes);
  return file;
}

}  // namespace segserve::codec
