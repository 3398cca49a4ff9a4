// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>

#include "core/lab/picture/picture.hpp"

namespace segserve::picture {

/// A pixel of an image, counted from its upper left corner. It may lie beyond the image.
struct Pixel {
  int x = 0;
  int y = 0;
};

/// A rectangle of pixels.
struct Box {
  int left = 0;
  int top = 0;
  int width = 0;
  int height = 0;
};

/// The height of capital letters in pixels, and the distance from one character to the next.
inline constexpr int kTextHeight = 14;
inline constexpr int kTextAdvance = 12;

/// An image of one color, 0x00RRGGBB.
Image blank_image(std::uint32_t width, std::uint32_t height, std::uint32_t rgb);

/// Draws on an image, which must outlive it. Colors are 0x00RRGGBB. What would lie beyond the image is left out.
class Canvas {
 public:
  explicit Canvas(Image& image) : image_(image) {}

  void put(Pixel at, std::uint32_t rgb);
  void fill(const Box& box, std::uint32_t rgb);
  /// A row or column of pixels from one to the other, both included. With `dash` above 0, so many pixels are drawn and
  /// as many left out in turn.
  void line(Pixel from, Pixel to, std::uint32_t rgb, int dash = 0);
  /// One line of text whose capital letters begin at a pixel. It is UTF-8; what is not ASCII becomes "?".
  void text(Pixel at, std::string_view text, std::uint32_t rgb);
  /// One line of text in the middle of the image, if it has room there.
  void text_in_middle(std::string_view text, std::uint32_t rgb);
  /// Copies an image so that its upper left corner lies at a pixel.
  void paste(Pixel at, const Image& picture);

 private:
  void glyph(Pixel at, char character, std::uint32_t rgb);

  Image& image_;
};

/// The text of a picture that shows no point.
inline constexpr std::string_view kNoPointsText = "no points";

/// How many characters `Canvas::text` draws for a text, and how wide they are in pixels.
std::size_t drawn_characters(std::string_view text);
int text_width(std::string_view text);

/// The text without its middle, for which ".." stands, if it is wider than so many pixels.
std::string shortened(std::string_view text, int width);

}  // namespace segserve::picture
