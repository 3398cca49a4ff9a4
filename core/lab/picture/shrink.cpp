// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "core/lab/picture/picture.hpp"

namespace segserve::picture {

Image shrink(const Image& image, std::uint32_t max_width) {
  const std::uint32_t limit = std::max(max_width, 1U);
  const std::uint32_t side = image.width / limit + (image.width % limit == 0 ? 0 : 1);
  if (side <= 1) return image;
  Image small{image.width / side, std::max(image.height / side, 1U), {}};
  small.rgb.reserve(std::size_t{3} * small.width * small.height);
  const std::uint32_t rows = std::min(side, image.height);  // of a square; fewer if the image is lower than one
  const std::uint32_t pixels = rows * side;
  for (std::uint32_t y = 0; y < small.height; ++y) {
    for (std::uint32_t x = 0; x < small.width; ++x) {
      for (std::size_t channel = 0; channel < 3; ++channel) {
        std::uint32_t sum = 0;
        for (std::uint32_t i = 0; i < pixels; ++i) {
          const std::size_t row = std::size_t{y} * side + i / side;
          const std::size_t column = std::size_t{x} * side + i % side;
          sum += image.rgb[3 * (row * image.width + column) + channel];
        }
        small.rgb.push_back(static_cast<std::uint8_t>((sum + pixels / 2) / pixels));
      }
    }
  }
  return small;
}

}  // namespace segserve::picture
