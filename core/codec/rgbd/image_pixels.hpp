// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <vector>

#include "core/codec/rgbd/image_size.hpp"

// Decoded images. Pixels stand row by row, from the top.
namespace segserve::codec {

/// A gray image of 16 bits a pixel.
struct GrayImage {
  ImageSize size;
  std::vector<std::uint16_t> pixels;  ///< width * height
};

/// A gray image of floats.
struct FloatImage {
  ImageSize size;
  std::vector<float> pixels;  ///< width * height
};

/// A color image of 8 bits a channel.
struct ColorImage {
  ImageSize size;
  std::vector<std::uint8_t> rgb;  ///< 3 * width * height: R, G, B of each pixel
};

}  // namespace segserve::codec
