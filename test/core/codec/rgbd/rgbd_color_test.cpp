// SPDX-License-Identifier: Apache-2.0
#include <gmock/gmock.h>

#include <cstdint>
#include <string>
#include <vector>

#include "core/codec/rgbd/jpeg_image.hpp"
#include "core/codec/rgbd/png_image.hpp"
#include "segserve/codec/rgbd.hpp"
#include "test/core/codec/rgbd/sample_images.hpp"
#include "test/core/codec/support/image_files.hpp"

namespace segserve::codec {
namespace {

TEST(Rgbd, JpegColorsAreNearlyTheSame) {
  ColorImage image{{16, 16}, std::vector<std::uint8_t>(std::size_t{3} * 16 * 16, 0)};
  for (std::size_t i = 0; i < image.rgb.size(); i += 3) image.rgb[i] = 200, image.rgb[i + 1] = 100;
  const auto cloud = decode_images(depth_png({16, 16}), encode_jpeg(image, 90).value());
  ASSERT_TRUE(cloud.ok()) << cloud.status();
  for (const std::uint32_t rgb : cloud->rgb) {
    EXPECT_NEAR(red(rgb), 200, 4);
    EXPECT_NEAR(green(rgb), 100, 4);
    EXPECT_NEAR(blue(rgb), 0, 4);
  }
}

absl::StatusOr<ColorImage> colors_in_png(const std::string& bytes) {
  GoOn go_on;
  return decode_png_color(bytes, {}, go_on.check);
}

TEST(Rgbd, ColorsAreReadFromEveryKindOfPng) {
  const std::vector<std::uint8_t> gray{10, 20, 30, 40};
  const auto from_gray = colors_in_png(png_file(2, 2, PNG_FORMAT_GRAY, gray.data()));
  ASSERT_TRUE(from_gray.ok()) << from_gray.status();
  EXPECT_EQ(from_gray->rgb, (std::vector<std::uint8_t>{10, 10, 10, 20, 20, 20, 30, 30, 30, 40, 40, 40}));
  const std::vector<std::uint8_t> rgba{1, 2, 3, 0, 4, 5, 6, 255};
  const auto from_rgba = colors_in_png(png_file(2, 1, PNG_FORMAT_RGBA, rgba.data()));
  ASSERT_TRUE(from_rgba.ok()) << from_rgba.status();
  EXPECT_EQ(from_rgba->rgb, (std::vector<std::uint8_t>{1, 2, 3, 4, 5, 6}));
  const std::vector<std::uint16_t> deep{0x1234, 0xabcd};
  const auto from_16 = colors_in_png(encode_png_gray16({2, 1}, deep).value());
  ASSERT_TRUE(from_16.ok()) << from_16.status();
  EXPECT_EQ(from_16->rgb, (std::vector<std::uint8_t>{0x12, 0x12, 0x12, 0xab, 0xab, 0xab}));
  const std::vector<std::uint8_t> indices{1, 0, 1}, colormap{7, 8, 9, 100, 110, 120};
  const auto from_palette = colors_in_png(png_file(3, 1, PNG_FORMAT_RGB_COLORMAP, indices.data(), colormap.data(), 2));
  ASSERT_TRUE(from_palette.ok()) << from_palette.status();
  EXPECT_EQ(from_palette->rgb, (std::vector<std::uint8_t>{100, 110, 120, 7, 8, 9, 100, 110, 120}));
}

TEST(Rgbd, ColorOfAnotherResolutionIsTakenFromTheNearestPixel) {
  const std::string depth = depth_png({4, 2});
  const auto finer = decode_images(depth, position_png({12, 6}));
  ASSERT_TRUE(finer.ok()) << finer.status();
  for (std::uint32_t i = 0; i < 8; ++i) EXPECT_EQ(finer->rgb[i], pack_rgb(3 * (i % 4) + 1, 3 * (i / 4) + 1, 7));
  const auto coarser = decode_images(depth, position_png({2, 1}));
  ASSERT_TRUE(coarser.ok()) << coarser.status();
  for (std::uint32_t i = 0; i < 8; ++i) EXPECT_EQ(coarser->rgb[i], pack_rgb(i % 4 / 2, 0, 7));
}

TEST(Rgbd, ColorIntrinsicsSayWhichPixelShowsAPoint) {
  const Intrinsics depth_camera{.fx = 50, .fy = 40, .cx = 2, .cy = 1};
  // Twice the resolution, with the center three columns and one row from its place.
  const Intrinsics color_camera{.fx = 100, .fy = 80, .cx = 7, .cy = 3};
  const std::vector<std::uint16_t> units(20, 1000);
  const std::string depth = encode_png_gray16({5, 4}, units).value(), color = position_png({9, 20});
  const auto decoded = decode_rgbd({depth, color, 0.001, depth_camera, color_camera}, {});
  ASSERT_TRUE(decoded.ok()) << decoded.status();
  std::size_t missing = 0;
  for (std::uint32_t v = 0; v < 4; ++v) {
    for (std::uint32_t u = 0; u < 5; ++u) {
      const std::uint32_t column = 2 * u + 3, row = 2 * v + 1;
      EXPECT_EQ(decoded->cloud.rgb[5 * v + u], column < 9 ? pack_rgb(column, row, 7) : 0U);
      missing += column < 9 ? 0 : 1;
    }
  }
  ASSERT_EQ(decoded->warnings.size(), 1U);
  EXPECT_EQ(decoded->warnings[0].reason, WarningReason::kColorMissing);
  EXPECT_THAT(decoded->warnings[0].message,
              testing::HasSubstr("does not show " + std::to_string(missing) + " of 20 points; they are black"));
  const Intrinsics far{.fx = 1e300, .fy = 1, .cx = -1e308, .cy = 0};
  EXPECT_THAT(decode_rgbd({depth, color, 0.001, depth_camera, far}, {})->warnings.at(0).message,
              testing::HasSubstr("20 of 20"));
  expect_fault(decode_rgbd({depth, color, 0.001, depth_camera, Intrinsics{}}, {}).status(), "color: fx is 0");
}

TEST(Rgbd, ColorOfOtherProportionsNeedsItsIntrinsics) {
  for (const ImageSize& size : {ImageSize{64, 48}, {32, 24}, {160, 120}, {107, 80}, {8, 6}, {21, 16}}) {
    EXPECT_TRUE(decode_images(depth_png({64, 48}), color_png(size)).ok()) << size.width;
  }
  for (const ImageSize& size : {ImageSize{64, 36}, {64, 49}, {48, 64}, {192, 108}, {2, 2}}) {
    expect_fault(decode_images(depth_png({64, 48}), color_png(size)).status(),
                 "color: it has " + std::to_string(size.width) + " x " + std::to_string(size.height) +
                     " pixels, and the depth image 64 x 48");
  }
}

TEST(Rgbd, ADamagedJpegIsUsedWithAWarning) {
  const std::string jpeg = encode_jpeg(colors_of({10, 7}), 90).value();
  const std::string cut = jpeg.substr(0, jpeg.size() - 2), depth = depth_png();
  const auto decoded = decode_rgbd({depth, cut, 0.001, kCamera}, {});
  ASSERT_TRUE(decoded.ok()) << decoded.status();
  EXPECT_EQ(decoded->cloud.rgb, decode_images(depth, jpeg).value().rgb);
  ASSERT_EQ(decoded->warnings.size(), 1U);
  EXPECT_EQ(decoded->warnings[0].reason, WarningReason::kImageDamaged);
  EXPECT_THAT(decoded->warnings[0].message, testing::HasSubstr("color: the JPEG is damaged: "));
}

}  // namespace
}  // namespace segserve::codec
