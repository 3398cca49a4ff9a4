// SPDX-License-Identifier: Apache-2.0
#include "core/lab/picture/canvas.hpp"

#include <algorithm>
#include <array>
#include <cstdlib>
#include <utility>

#include "core/lab/picture/glyphs.hpp"

namespace segserve::picture {
namespace {

bool is_inked(const Glyph& glyph, int column, int row) {
  if (column < 0 || column >= kGlyphWidth || row < 0 || row >= kGlyphHeight) return false;
  return ((static_cast<unsigned>(glyph[static_cast<std::size_t>(column)]) >> static_cast<unsigned>(row)) & 1U) != 0;
}

/// The four pixels that a pixel of a glyph becomes at twice the size, row by row. Diagonals become smooth (the rule of
/// Scale2x, A. Mazzoleni).
std::array<bool, 4> doubled(const Glyph& glyph, int column, int row) {
  const bool own = is_inked(glyph, column, row);
  const bool up = is_inked(glyph, column, row - 1);
  const bool down = is_inked(glyph, column, row + 1);
  const bool left = is_inked(glyph, column - 1, row);
  const bool right = is_inked(glyph, column + 1, row);
  if (up == down || left == right) return {own, own, own, own};
  return {left == up ? left : own, up == right ? right : own, left == down ? left : own, down == right ? right : own};
}

bool continues_character(char byte) { return (static_cast<unsigned char>(byte) & 0xC0U) == 0x80U; }

}  // namespace

Image blank_image(std::uint32_t width, std::uint32_t height, std::uint32_t rgb) {
  Image image{width, height, std::vector<std::uint8_t>(std::size_t{3} * width * height)};
  for (std::size_t i = 0; i < image.rgb.size(); i += 3) {
    image.rgb[i] = red(rgb);
    image.rgb[i + 1] = green(rgb);
    image.rgb[i + 2] = blue(rgb);
  }
  return image;
}

void Canvas::put(Pixel at, std::uint32_t rgb) {
  if (at.x < 0 || at.y < 0 || at.x >= static_cast<int>(image_.width) || at.y >= static_cast<int>(image_.height)) return;
  const std::size_t i = 3 * (static_cast<std::size_t>(at.y) * image_.width + static_cast<std::size_t>(at.x));
  image_.rgb[i] = red(rgb);
  image_.rgb[i + 1] = green(rgb);
  image_.rgb[i + 2] = blue(rgb);
}

void Canvas::fill(const Box& box, std::uint32_t rgb) {
  const int right = std::min(box.left + box.width, static_cast<int>(image_.width));
  const int bottom = std::min(box.top + box.height, static_cast<int>(image_.height));
  for (int y = std::max(box.top, 0); y < bottom; ++y) {
    for (int x = std::max(box.left, 0); x < right; ++x) put({x, y}, rgb);
  }
}

void Canvas::line(Pixel from, Pixel to, std::uint32_t rgb, int dash) {
  const int steps = std::max(std::abs(to.x - from.x), std::abs(to.y - from.y));
  for (int i = 0; i <= steps; ++i) {
    if (dash > 0 && i / dash % 2 == 1) continue;
    const double share = steps == 0 ? 0.0 : static_cast<double>(i) / steps;
    put({from.x + static_cast<int>(share * (to.x - from.x)), from.y + static_cast<int>(share * (to.y - from.y))}, rgb);
  }
}

void Canvas::glyph(Pixel at, char character, std::uint32_t rgb) {
  const Glyph& glyph = glyph_of(character);
  for (int row = 0; row < kGlyphHeight; ++row) {
    for (int column = 0; column < kGlyphWidth; ++column) {
      const auto inked = doubled(glyph, column, row);
      for (int part = 0; part < 4; ++part) {
        if (inked[static_cast<std::size_t>(part)]) put({at.x + 2 * column + part % 2, at.y + 2 * row + part / 2}, rgb);
      }
    }
  }
}

void Canvas::text(Pixel at, std::string_view text, std::uint32_t rgb) {
  for (const char character : text) {
    if (continues_character(character)) continue;
    glyph(at, character, rgb);
    at.x += kTextAdvance;
  }
}

void Canvas::text_in_middle(std::string_view text, std::uint32_t rgb) {
  const int width = text_width(text);
  const auto image_width = static_cast<int>(image_.width), image_height = static_cast<int>(image_.height);
  if (width > image_width || kTextHeight > image_height) return;
  this->text({(image_width - width) / 2, (image_height - kTextHeight) / 2}, text, rgb);
}

void Canvas::paste(Pixel at, const Image& picture) {
  for (std::uint32_t y = 0; y < picture.height; ++y) {
    for (std::uint32_t x = 0; x < picture.width; ++x) {
      const std::size_t i = 3 * (std::size_t{y} * picture.width + x);
      put({at.x + static_cast<int>(x), at.y + static_cast<int>(y)},
          pack_rgb(picture.rgb[i], picture.rgb[i + 1], picture.rgb[i + 2]));
    }
  }
}

std::size_t drawn_characters(std::string_view text) {
  return text.size() - static_cast<std::size_t>(std::ranges::count_if(text, continues_character));
}

int text_width(std::string_view text) { return kTextAdvance * static_cast<int>(drawn_characters(text)); }

std::string shortened(std::string_view text, int width) {
  if (text_width(text) <= width) return std::string(text);
  const auto kept = static_cast<std::size_t>(std::max(width / kTextAdvance - 2, 0));
  const std::size_t front = (kept + 1) / 2;
  std::string head;
  std::string tail;
  std::size_t at = 0;
  const std::size_t all = drawn_characters(text);
  for (const char character : text) {
    if (!continues_character(character)) ++at;
    if (at <= front) head += character;
    if (at > all - (kept - front)) tail += character;
  }
  return head + ".." + tail;
}

}  // namespace segserve::picture
