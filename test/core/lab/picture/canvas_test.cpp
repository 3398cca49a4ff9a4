// SPDX-License-Identifier: Apache-2.0
#include "core/lab/picture/canvas.hpp"

#include <gmock/gmock.h>

#include <algorithm>
#include <set>
#include <string>

namespace segserve::picture {
namespace {

constexpr std::uint32_t kInk = 0xFFFFFF;

bool is_inked(const Image& image, std::uint32_t x, std::uint32_t y) {
  return image.rgb[3 * (std::size_t{y} * image.width + x)] != 0;
}

/// The rows of an image as text.
std::string drawn(const Image& image) {
  std::string text;
  for (std::uint32_t y = 0; y < image.height; ++y) {
    for (std::uint32_t x = 0; x < image.width; ++x) text += is_inked(image, x, y) ? '#' : '.';
    text += '\n';
  }
  return text;
}

std::size_t ink(const Image& image) {
  const std::string text = drawn(image);
  return static_cast<std::size_t>(std::count(text.begin(), text.end(), '#'));
}

TEST(Canvas, FillsAndLines) {
  Image image = blank_image(6, 4, 0);
  Canvas canvas(image);
  canvas.fill({1, 1, 2, 2}, kInk);
  canvas.line({5, 0}, {5, 3}, kInk);
  EXPECT_EQ(drawn(image), ".....#\n.##..#\n.##..#\n.....#\n");
}

TEST(Canvas, DashesLeaveGaps) {
  Image image = blank_image(8, 1, 0);
  Canvas(image).line({0, 0}, {7, 0}, kInk, 2);
  EXPECT_EQ(drawn(image), "##..##..\n");
}

TEST(Canvas, LeavesOutWhatIsBeyondTheImage) {
  Image image = blank_image(4, 4, 0);
  Canvas canvas(image);
  canvas.fill({-100, -100, 102, 102}, kInk);
  canvas.line({-5, 3}, {100, 3}, kInk);
  canvas.text({-30, -3}, "far away", kInk);
  canvas.paste({3, 3}, blank_image(9, 9, kInk));
  EXPECT_TRUE(is_inked(image, 0, 0));
  EXPECT_TRUE(is_inked(image, 3, 3));
  EXPECT_FALSE(is_inked(image, 3, 1));
}

TEST(Canvas, WritesText) {
  Image image = blank_image(10, 14, 0);
  Canvas(image).text({0, 0}, "T", kInk);
  EXPECT_EQ(drawn(image).substr(0, 11), "##########\n");
  EXPECT_EQ(drawn(image).substr(13 * 11, 11), "....##....\n");
}

TEST(Canvas, EveryCharacterOfAsciiLooksDifferent) {
  std::set<std::string> glyphs;
  for (char c = ' '; c <= '~'; ++c) {
    Image image = blank_image(12, 14, 0);
    Canvas(image).text({0, 0}, std::string(1, c), kInk);
    EXPECT_EQ(ink(image) == 0, c == ' ') << c;
    glyphs.insert(drawn(image));
  }
  EXPECT_EQ(glyphs.size(), 95U);
}

TEST(Canvas, OtherCharactersAreQuestionMarks) {
  Image image = blank_image(30, 14, 0);
  Image expected = image;
  Canvas(image).text({0, 0}, "\u00e9\u4e16", kInk);
  Canvas(expected).text({0, 0}, "??", kInk);
  EXPECT_EQ(image.rgb, expected.rgb);
  EXPECT_EQ(text_width("\u00e9\u4e16"), 2 * kTextAdvance);
}

TEST(Shortened, LosesItsMiddle) {
  EXPECT_EQ(shortened("scene.pcd", 9 * kTextAdvance), "scene.pcd");
  EXPECT_EQ(shortened("scene.pcd", 8 * kTextAdvance), "sce..pcd");
  EXPECT_EQ(shortened("scene.pcd", 0), "..");
  EXPECT_EQ(shortened("\u00e9\u00e9\u00e9\u00e9\u00e9\u00e9", 4 * kTextAdvance), "\u00e9..\u00e9");
}

}  // namespace
}  // namespace segserve::picture
