// SPDX-License-Identifier: Apache-2.0
#include <gmock/gmock.h>

#include <cmath>
#include <limits>

#include "core/lab/picture/picture.hpp"

namespace segserve::picture {
namespace {

constexpr float kNan = std::numeric_limits<float>::quiet_NaN();

std::uint32_t pixel(const Image& image, std::uint32_t x, std::uint32_t y) {
  const std::size_t i = 3 * (std::size_t{y} * image.width + x);
  return pack_rgb(image.rgb[i], image.rgb[i + 1], image.rgb[i + 2]);
}

/// 4 x 2 points in front of the camera, two rows of one color each; the last point is missing.
Cloud small_image() {
  Cloud cloud;
  cloud.resize(8, true);
  cloud.width = 4;
  cloud.height = 2;
  for (std::size_t i = 0; i < 8; ++i) {
    cloud.x[i] = static_cast<float>(i % 4);
    cloud.y[i] = static_cast<float>(i / 4);
    cloud.z[i] = i == 7 ? kNan : 2.0F;
    cloud.rgb[i] = i < 4 ? 0xC08040 : 0x4080C0;
  }
  return cloud;
}

/// A square of n x n points with side 1 in the plane z = height.
void add_square(float left, float front, float height, std::uint32_t rgb, int n, Cloud& cloud) {
  for (int i = 0; i < n * n; ++i) {
    cloud.x.push_back(left + static_cast<float>(i % n) / static_cast<float>(n));
    cloud.y.push_back(front + static_cast<float>(i / n) / static_cast<float>(n));
    cloud.z.push_back(height);
    cloud.rgb.push_back(rgb);
  }
  cloud.width = static_cast<std::uint32_t>(cloud.size());
  cloud.height = 1;
}

std::size_t count_pixels(const Image& image, bool (*predicate)(std::uint32_t)) {
  std::size_t count = 0;
  for (std::uint32_t y = 0; y < image.height; ++y) {
    for (std::uint32_t x = 0; x < image.width; ++x) count += predicate(pixel(image, x, y)) ? 1 : 0;
  }
  return count;
}
bool is_red(std::uint32_t rgb) { return red(rgb) > green(rgb) && red(rgb) > blue(rgb); }
bool is_green(std::uint32_t rgb) { return green(rgb) > red(rgb) && green(rgb) > blue(rgb); }
bool is_background(std::uint32_t rgb) { return rgb == RenderOptions{}.background; }

TEST(RenderOrganized, OwnColorsAreTheImage) {
  const Image image = render(small_image(), {});
  ASSERT_EQ(image.width, 4U);
  ASSERT_EQ(image.height, 2U);
  EXPECT_EQ(pixel(image, 0, 0), 0xC08040U);
  EXPECT_EQ(pixel(image, 2, 1), 0x4080C0U);
  EXPECT_EQ(pixel(image, 3, 1), RenderOptions{}.background);
}

TEST(RenderOrganized, SegmentsAreColoredAndBordersDark) {
  const std::vector<std::uint32_t> labels{5, 5, 6, 6, 5, 5, 6, 0};
  const Cloud cloud = small_image();
  const Image plain = render(cloud, labels, {.blend = 1.0F, .borders = false});
  const Image bordered = render(cloud, labels, {.blend = 1.0F, .borders = true});
  EXPECT_EQ(pixel(plain, 0, 0), pixel(plain, 1, 0));
  EXPECT_NE(pixel(plain, 1, 0), pixel(plain, 2, 0));
  EXPECT_EQ(pixel(bordered, 0, 0), pixel(plain, 0, 0));
  EXPECT_EQ(pixel(bordered, 2, 0), pixel(plain, 2, 0));
  EXPECT_LT(red(pixel(bordered, 1, 0)) + green(pixel(bordered, 1, 0)) + blue(pixel(bordered, 1, 0)), 220);
  EXPECT_NE(pixel(bordered, 1, 0), pixel(plain, 1, 0));
  // No border where there is no point beside.
  EXPECT_EQ(pixel(bordered, 2, 1), pixel(plain, 2, 1));
}

TEST(RenderOrganized, BlendGoesFromTheOwnColorToTheSegments) {
  const std::vector<std::uint32_t> labels(8, 3);
  const Cloud cloud = small_image();
  EXPECT_EQ(render(cloud, labels, {.blend = 0.0F}).rgb, render(cloud, {}).rgb);
  const Image full = render(cloud, labels, {.blend = 1.0F});
  const Image half = render(cloud, labels, {.blend = 0.5F});
  EXPECT_NEAR(red(pixel(half, 0, 0)), (0xC0 + red(pixel(full, 0, 0))) / 2.0, 1.0);
}

TEST(RenderOrganized, WithoutColorNearIsLighterThanFar) {
  Cloud cloud = small_image();
  cloud.rgb.clear();
  for (std::size_t i = 0; i < 7; ++i) cloud.z[i] = 1.0F + static_cast<float>(i);
  const Image image = render(cloud, {});
  EXPECT_GT(red(pixel(image, 0, 0)), red(pixel(image, 3, 0)));
  EXPECT_GT(red(pixel(image, 3, 0)), red(pixel(image, 2, 1)));
  EXPECT_EQ(red(pixel(image, 1, 0)), green(pixel(image, 1, 0)));
}

TEST(RenderProjected, CameraCloudsAreSeenFromTheCamera) {
  Cloud cloud;
  cloud.view = View::camera();
  add_square(-0.5F, -0.5F, 2.0F, 0xFF0000, 60, cloud);
  add_square(-0.5F, -0.5F, 4.0F, 0x00FF00, 60, cloud);  // behind, and hidden
  const Image image = render(cloud, {}, {.width = 200, .height = 150});
  ASSERT_EQ(image.width, 200U);
  ASSERT_EQ(image.height, 150U);
  EXPECT_TRUE(is_red(pixel(image, 100, 75)));
  EXPECT_EQ(count_pixels(image, is_green), 0U);
  // It fills the height of the picture, without holes.
  EXPECT_GT(count_pixels(image, is_red), 120U * 120U);
  EXPECT_TRUE(is_background(pixel(image, 2, 75)));
}

TEST(RenderProjected, WorldCloudsAroundTheirSensorAreSeenFromAboveOnItsSide) {
  Cloud cloud;
  cloud.view = View::world(0.9F, 0.5F, 0.5F);
  add_square(0.0F, 0.0F, 0.0F, 0x00FF00, 80, cloud);
  add_square(0.0F, 0.0F, 1.0F, 0xFF0000, 80, cloud);  // a roof over the floor
  const Image image = render(cloud, {}, {.width = 200, .height = 200});
  EXPECT_GT(count_pixels(image, is_red), count_pixels(image, is_green));
  // Points nearer to the sensor are lower in the picture, so that the floor shows there.
  std::uint32_t lowest_red = 0;
  std::uint32_t lowest_green = 0;
  for (std::uint32_t y = 0; y < 200; ++y) {
    if (is_red(pixel(image, 100, y))) lowest_red = y;
    if (is_green(pixel(image, 100, y))) lowest_green = y;
  }
  EXPECT_GT(lowest_green, lowest_red);
}

TEST(RenderProjected, WorldCloudsAreSeenFromASensorThatSeesThemWhole) {
  Cloud cloud;
  cloud.view = View::world(0.5F, 0.5F, -4.0F);
  add_square(0.0F, 0.0F, 0.0F, 0x00FF00, 80, cloud);
  add_square(0.0F, 0.0F, 1.0F, 0xFF0000, 80, cloud);  // behind the floor for a sensor below it
  const Image image = render(cloud, {}, {.width = 200, .height = 200});
  EXPECT_GT(count_pixels(image, is_green), 120U * 120U);
  EXPECT_EQ(count_pixels(image, is_red), 0U);
}

TEST(RenderProjected, ViewFromDecides) {
  Cloud cloud;
  cloud.view = View::camera();
  add_square(-0.5F, -0.5F, 2.0F, 0xFF0000, 60, cloud);
  add_square(-0.5F, -0.5F, 4.0F, 0x00FF00, 60, cloud);
  const RenderOptions behind{.width = 200, .height = 150, .view_from = Eigen::Vector3f(0, 0, 9)};
  const Image image = render(cloud, {}, behind);
  EXPECT_TRUE(is_green(pixel(image, 100, 75)));
  EXPECT_EQ(count_pixels(image, is_red), 0U);
  // From the side both are seen, and the picture is upright: z to the right, from the red square to the green one.
  const Image side = render(cloud, {}, {.width = 200, .height = 150, .view_from = Eigen::Vector3f(-9, -1, 3)});
  EXPECT_GT(count_pixels(side, is_green), 50U);
  EXPECT_GT(count_pixels(side, is_red), 50U);
  std::uint32_t left_red = 200, left_green = 200;
  for (std::uint32_t x = 200; x-- > 0;) {
    for (std::uint32_t y = 0; y < 150; ++y) {
      if (is_red(pixel(side, x, y))) left_red = x;
      if (is_green(pixel(side, x, y))) left_green = x;
    }
  }
  EXPECT_LT(left_green, left_red) << "from the left of the camera, what is far from it is at the left";
}

TEST(RenderProjected, ViewFromTurnsAnImageIntoAScene) {
  const Image image = render(small_image(), {}, {.width = 64, .height = 48, .view_from = Eigen::Vector3f(0, 0, -5)});
  EXPECT_EQ(image.width, 64U);
  // Straight from above, nothing in the picture is up by itself.
  EXPECT_EQ(render(small_image(), {}, {.width = 64, .height = 48, .view_from = Eigen::Vector3f(1.5F, -50, 2)}).width,
            64U);
}

TEST(RenderLegend, StandsBesideThePicture) {
  Cloud cloud;
  cloud.view = View::world();
  add_square(0.0F, 0.0F, 0.0F, 0x808080, 50, cloud);
  const std::vector<std::uint32_t> labels(cloud.size(), 1);
  const RenderOptions options{.width = 200, .height = 150};
  RenderOptions with_legend = options;
  with_legend.legend = true;
  const Image plain = render(cloud, labels, options);
  const Image image = render(cloud, labels, with_legend);
  EXPECT_GT(image.width, plain.width + 100);
  EXPECT_EQ(image.height, plain.height);
  EXPECT_EQ(pixel(image, 10, 10), pixel(plain, 10, 10));
  bool has_swatch = false;
  for (std::uint32_t x = plain.width; x < image.width; ++x) has_swatch |= pixel(image, x, 55) == segment_color(1);
  EXPECT_TRUE(has_swatch);
  EXPECT_EQ(render(cloud, {}, with_legend).width, plain.width) << "without labels there is none";
}

TEST(RenderProjected, LabelsColorPoints) {
  Cloud cloud;
  cloud.view = View::world();
  add_square(0.0F, 0.0F, 0.0F, 0x808080, 50, cloud);
  const std::vector<std::uint32_t> labels(cloud.size(), 1);
  const Image image = render(cloud, labels, {.blend = 1.0F});
  const std::uint32_t expected = segment_color(1);
  const std::uint32_t middle = pixel(image, image.width / 2, image.height / 2);
  EXPECT_NEAR(static_cast<double>(blue(middle)) / green(middle), static_cast<double>(blue(expected)) / green(expected),
              0.05);
}

TEST(RenderOddInput, GivesAPicture) {
  const RenderOptions options{.width = 64, .height = 48};
  const Image empty = render(Cloud{}, {}, options);
  EXPECT_EQ(empty.rgb.size(), 3U * 64 * 48);
  EXPECT_EQ(count_pixels(empty, is_background), 64U * 48U);

  Cloud one{{1}, {2}, {3}, {0x00FF00}, 1, 1, View::world()};
  EXPECT_TRUE(is_green(pixel(render(one, {}, options), 32, 24)));
  one.view = View::camera();
  EXPECT_TRUE(is_green(pixel(render(one, {}, options), 32, 24)));
  one.z[0] = -1;  // behind the camera
  EXPECT_EQ(count_pixels(render(one, {}, options), is_background), 64U * 48U);
  one.x[0] = kNan;
  EXPECT_EQ(count_pixels(render(one, {}, options), is_background), 64U * 48U);

  Cloud far{{1e30F, -1e30F, 3e38F}, {0, 1, 2}, {3, 4, 5}, {}, 3, 1, View::world()};
  EXPECT_EQ(render(far, {}, options).rgb.size(), 3U * 64 * 48);
}

}  // namespace
}  // namespace segserve::picture
