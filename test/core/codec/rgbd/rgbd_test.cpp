// SPDX-License-Identifier: Apache-2.0
#include "segserve/codec/rgbd.hpp"

#include <png.h>

#include <cmath>
#include <string>
#include <utility>
#include <vector>

#include "core/codec/rgbd/jpeg_image.hpp"
#include "core/codec/rgbd/png_image.hpp"
#include "segserve/codec/rgbd_encode.hpp"
#include "test/core/codec/support/damaged_bytes.hpp"
#include "test/core/codec/support/sample_cloud.hpp"

namespace segserve::codec {
namespace {

constexpr Intrinsics kCamera{.fx = 50, .fy = 40, .cx = 4.5, .cy = 3};

/// Depths in millimeters. Every fifth pixel is 0.
std::vector<std::uint16_t> depth_of(const ImageSize& size) {
  std::vector<std::uint16_t> depth(size.pixels());
  for (std::size_t i = 0; i < depth.size(); ++i) depth[i] = i % 5 == 2 ? 0 : static_cast<std::uint16_t>(900 + 7 * i);
  return depth;
}

std::string depth_png(const ImageSize& size = {10, 7}) { return encode_png_gray16(size, depth_of(size)).value(); }

ColorImage colors_of(const ImageSize& size) {
  ColorImage image{size, {}};
  for (std::size_t i = 0; i < 3 * size.pixels(); ++i) image.rgb.push_back(static_cast<std::uint8_t>(60 + i));
  return image;
}

/// A PNG in any of libpng's simple formats.
std::string png_file(std::uint32_t width, std::uint32_t height, png_uint_32 format, const void* pixels) {
  png_image image{};
  image.version = PNG_IMAGE_VERSION;
  image.width = width;
  image.height = height;
  image.format = format;
  png_alloc_size_t size = 0;
  EXPECT_NE(png_image_write_to_memory(&image, nullptr, &size, 0, pixels, 0, nullptr), 0);
  std::string bytes(size, '\0');
  EXPECT_NE(png_image_write_to_memory(&image, bytes.data(), &size, 0, pixels, 0, nullptr), 0);
  bytes.resize(size);
  return bytes;
}

std::string color_png(const ImageSize& size = {10, 7}) {
  return png_file(size.width, size.height, PNG_FORMAT_RGB, colors_of(size).rgb.data());
}

absl::StatusOr<Cloud> decode(const std::string& depth, const std::string& color, const DecodeLimits& limits = {}) {
  return decode_rgbd({depth, color, 0.001, kCamera}, limits);
}

TEST(Rgbd, PixelsBecomePointsByThePinholeModel) {
  const auto cloud = decode(depth_png(), color_png());
  ASSERT_TRUE(cloud.ok()) << cloud.status();
  EXPECT_EQ(cloud->width, 10U);
  EXPECT_EQ(cloud->height, 7U);
  EXPECT_EQ(cloud->view, View::camera());
  const std::vector<std::uint16_t> depth = depth_of({10, 7});
  const ColorImage colors = colors_of({10, 7});
  for (std::uint32_t v = 0; v < 7; ++v) {
    for (std::uint32_t u = 0; u < 10; ++u) {
      const std::size_t i = v * 10 + u;
      EXPECT_EQ(cloud->rgb[i], pack_rgb(colors.rgb[3 * i], colors.rgb[3 * i + 1], colors.rgb[3 * i + 2]));
      if (depth[i] == 0) {
        EXPECT_TRUE(std::isnan(cloud->x[i]) && std::isnan(cloud->y[i]) && std::isnan(cloud->z[i]));
        continue;
      }
      const double z = depth[i] * 0.001;
      EXPECT_EQ(cloud->x[i], static_cast<float>((u - 4.5) / 50 * z));
      EXPECT_EQ(cloud->y[i], static_cast<float>((v - 3.0) / 40 * z));
      EXPECT_EQ(cloud->z[i], static_cast<float>(z));
    }
  }
}

TEST(Rgbd, WithoutColor) {
  const auto cloud = decode(depth_png(), "");
  ASSERT_TRUE(cloud.ok()) << cloud.status();
  EXPECT_FALSE(cloud->has_color());
}

TEST(Rgbd, JpegColorsAreNearlyTheSame) {
  ColorImage image{{16, 16}, std::vector<std::uint8_t>(std::size_t{3} * 16 * 16, 0)};
  for (std::size_t i = 0; i < image.rgb.size(); i += 3) image.rgb[i] = 200, image.rgb[i + 1] = 100;
  const auto cloud = decode(depth_png({16, 16}), encode_jpeg(image, 90).value());
  ASSERT_TRUE(cloud.ok()) << cloud.status();
  for (const std::uint32_t rgb : cloud->rgb) {
    EXPECT_NEAR(red(rgb), 200, 4);
    EXPECT_NEAR(green(rgb), 100, 4);
    EXPECT_NEAR(blue(rgb), 0, 4);
  }
}

TEST(Rgbd, ColorsAreReadFromEveryKindOfPng) {
  const std::vector<std::uint8_t> gray{10, 20, 30, 40};
  const auto from_gray = decode_png_color(png_file(2, 2, PNG_FORMAT_GRAY, gray.data()), {});
  ASSERT_TRUE(from_gray.ok()) << from_gray.status();
  EXPECT_EQ(from_gray->rgb, (std::vector<std::uint8_t>{10, 10, 10, 20, 20, 20, 30, 30, 30, 40, 40, 40}));
  const std::vector<std::uint8_t> rgba{1, 2, 3, 0, 4, 5, 6, 255};
  const auto from_rgba = decode_png_color(png_file(2, 1, PNG_FORMAT_RGBA, rgba.data()), {});
  ASSERT_TRUE(from_rgba.ok()) << from_rgba.status();
  EXPECT_EQ(from_rgba->rgb, (std::vector<std::uint8_t>{1, 2, 3, 4, 5, 6}));
  const std::vector<std::uint16_t> deep{0x1234, 0xabcd};
  const auto from_16 = decode_png_color(encode_png_gray16({2, 1}, deep).value(), {});
  ASSERT_TRUE(from_16.ok()) << from_16.status();
  EXPECT_EQ(from_16->rgb, (std::vector<std::uint8_t>{0x12, 0x12, 0x12, 0xab, 0xab, 0xab}));
}

TEST(Rgbd, FaultsNameTheImageAndTheNumbers) {
  expect_fault(decode("", color_png()).status(), "depth: PNG: the bytes do not begin with a PNG signature");
  expect_fault(decode(color_png(), color_png()).status(),
               "color type 2 with 8 bits, but must be gray (0) with 16 bits");
  expect_fault(decode(depth_png(), "GIF89a").status(), "color: the bytes are neither PNG nor JPEG");
  expect_fault(decode(depth_png(), color_png({9, 7})).status(),
               "the color image has 9 x 7 pixels, but the depth image has 10 x 7");
  const std::string depth = depth_png();
  expect_fault(decode_rgbd({depth, "", 0.001, {.fx = 0, .fy = NAN, .cx = INFINITY, .cy = 0}}, {}).status(),
               "fx is 0, which is not a finite number above 0; fy is nan, which is not a finite number above 0; "
               "cx is inf, which is not finite");
  for (const double scale : {0.0, -1.0, double{NAN}, double{INFINITY}}) {
    expect_fault(decode_rgbd({depth, "", scale, kCamera}, {}).status(), "the depth scale is");
  }
}

/// The PNG with another size in its IHDR, whose big-endian numbers follow the signature, the length and the name.
std::string with_size(std::string png, std::uint32_t width, std::uint32_t height) {
  for (unsigned i = 0; i < 4; ++i) {
    png[16 + i] = static_cast<char>(width >> (24 - 8 * i));
    png[20 + i] = static_cast<char>(height >> (24 - 8 * i));
  }
  return png;
}

TEST(Rgbd, LyingSizesAreRefusedBeforeAllocation) {
  expect_over_limit(decode(with_size(depth_png(), 0x7fffffff, 0x7fffffff), "").status(), "max_points",
                    "depth: 2147483647 x 2147483647 pixels exceed the limit");
  expect_over_limit(decode(depth_png(), with_size(color_png(), 100'000, 100'000)).status(), "max_points", "color: ");
  expect_fault(decode(with_size(depth_png(), 0, 7), "").status(), "0 x 7 pixels are not the size of an image");
  expect_fault(decode(with_size(depth_png(), 0x80000000U, 1), "").status(), "are not the size of an image");
  expect_over_limit(decode(depth_png(), "", {.max_points = 69}).status(), "max_points", "10 x 7 pixels");
  expect_over_limit(decode(depth_png(), "", {.max_bytes = 1000}).status(), "max_bytes", "of 16 bytes exceed");
  std::string jpeg = encode_jpeg(colors_of({10, 7}), 90).value();
  const std::size_t frame = jpeg.find("\xff\xc0");
  ASSERT_NE(frame, std::string::npos);
  for (const std::size_t at : {5U, 6U, 7U, 8U}) jpeg[frame + at] = '\xf0';
  expect_over_limit(decode(depth_png(), jpeg).status(), "max_points", "color: 61680 x 61680 pixels");
}

TEST(Rgbd, DamageIsRefusedOrDecodedWithinBounds) {
  const std::string depth = depth_png();
  const std::string png = color_png();
  const std::string jpeg = encode_jpeg(colors_of({10, 7}), 90).value();
  const auto damaged_depth = [](const std::string& bytes) { return decode(bytes, "", kDamageLimits); };
  const auto damaged_color = [&](const std::string& bytes) {
    return bytes.empty() ? absl::InvalidArgumentError("no image") : decode(depth, bytes, kDamageLimits);
  };
  expect_truncations_refused(depth, damaged_depth);
  expect_truncations_refused(png, damaged_color);
  expect_truncations_refused(jpeg, damaged_color);
  expect_flips_survived(depth, damaged_depth);
  expect_flips_survived(png, damaged_color);
  expect_flips_survived(jpeg, damaged_color);
}

/// An organized cloud that kCamera sees, with points in front of it.
Cloud camera_cloud(bool color) {
  const auto cloud = decode(depth_png({20, 15}), color ? color_png({20, 15}) : "");
  EXPECT_TRUE(cloud.ok()) << cloud.status();
  return *cloud;
}

TEST(RgbdEncode, GivesBackTheImagesAndTheCamera) {
  for (const bool color : {false, true}) {
    const Cloud cloud = camera_cloud(color);
    const auto files = encode_rgbd(cloud);
    ASSERT_TRUE(files.ok()) << files.status();
    EXPECT_NEAR(files->intrinsics.fx, kCamera.fx, 1e-4);
    EXPECT_NEAR(files->intrinsics.cy, kCamera.cy, 1e-4);
    EXPECT_LT(files->error_bound, 1e-6);
    const auto decoded = decode_rgbd(files->images(), {});
    ASSERT_TRUE(decoded.ok()) << decoded.status();
    EXPECT_EQ(bits(decoded->z), bits(cloud.z));
    EXPECT_EQ(decoded->has_color(), color);
  }
}

TEST(RgbdEncode, TheDeclaredErrorBoundIsTheLargestError) {
  Cloud cloud = camera_cloud(false);
  for (std::size_t i = 0; i < cloud.size(); ++i) cloud.z[i] += 0.0004F * static_cast<float>(i % 3);
  const auto files = encode_rgbd(cloud, {.intrinsics = kCamera});
  ASSERT_TRUE(files.ok()) << files.status();
  const Cloud decoded = decode_rgbd(files->images(), {}).value();
  double largest = 0;
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    const bool finite = is_finite(cloud.x[i], cloud.y[i], cloud.z[i]);
    ASSERT_EQ(is_finite(decoded.x[i], decoded.y[i], decoded.z[i]), finite);
    if (!finite) continue;
    for (const auto& [a, b] :
         {std::pair(cloud.x[i], decoded.x[i]), {cloud.y[i], decoded.y[i]}, {cloud.z[i], decoded.z[i]}}) {
      largest = std::max(largest, std::abs(double{a} - b));
    }
  }
  EXPECT_EQ(files->error_bound, largest);
  EXPECT_GT(largest, 0.0001);
}

TEST(RgbdEncode, RefusesCloudsThatAreNotImages) {
  Cloud cloud = camera_cloud(false);
  cloud.view = View::world();
  expect_fault(encode_rgbd(cloud).status(), "only an organized cloud");
  cloud = camera_cloud(false);
  cloud.x[0] += 0.1F;
  expect_fault(encode_rgbd(cloud).status(), "not the image of a pinhole camera");
  expect_fault(encode_rgbd(camera_cloud(false), {.depth_scale = 0.00001}).status(), "does not fit into 1 to 65535");
  for (float& x : cloud.x) x = NAN;
  expect_fault(encode_rgbd(cloud).status(), "the points do not determine the camera");
}

}  // namespace
}  // namespace segserve::codec
