// SPDX-License-Identifier: Apache-2.0
#include "segserve/codec/rgbd.hpp"

#include <gmock/gmock.h>

#include <atomic>
#include <cmath>
#include <string>
#include <utility>
#include <vector>

#include "core/codec/rgbd/jpeg_image.hpp"
#include "core/codec/rgbd/png_image.hpp"
#include "segserve/codec/rgbd_encode.hpp"
#include "test/core/codec/support/damaged_bytes.hpp"
#include "test/core/codec/support/image_files.hpp"
#include "test/core/codec/support/npy_file.hpp"
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

std::string color_png(const ImageSize& size = {10, 7}) {
  return png_file(size.width, size.height, PNG_FORMAT_RGB, colors_of(size).rgb.data());
}

absl::StatusOr<Cloud> decode(const std::string& depth, const std::string& color, const DecodeLimits& limits = {}) {
  auto decoded = decode_rgbd({depth, color, 0.001, kCamera}, limits);
  if (!decoded.ok()) return decoded.status();
  EXPECT_TRUE(decoded->label.empty());
  EXPECT_EQ(decoded->view_rule, "CAMERA, as RGB-D images are");
  return std::move(decoded->cloud);
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

TEST(Rgbd, DepthsThatAreNoneBecomeNoPointsAndAreCounted) {
  const std::vector<std::uint16_t> units{0, 65535, 65535, 1200};
  const auto integers = decode_rgbd({encode_png_gray16({2, 2}, units).value(), "", 0.001, kCamera}, {});
  ASSERT_TRUE(integers.ok()) << integers.status();
  for (const std::size_t i : {0U, 1U, 2U}) EXPECT_TRUE(std::isnan(integers->cloud.z[i]));
  EXPECT_EQ(integers->cloud.z[3], 1.2F);
  ASSERT_EQ(integers->warnings.size(), 1U);
  EXPECT_EQ(integers->warnings[0].reason, WarningReason::kPointsNotUsed);
  EXPECT_THAT(integers->warnings[0].message, testing::HasSubstr("depth: 2 of 4 pixels are 65535"));

  const std::vector<float> meters{1.5F, -1, 0, NAN, INFINITY, 65535};
  std::string pfm = "Pf 6 1 -1 ";
  pfm.append(reinterpret_cast<const char*>(meters.data()), 4 * meters.size());
  const auto floats = decode_rgbd({pfm, "", 1, kCamera}, {});
  ASSERT_TRUE(floats.ok()) << floats.status();
  EXPECT_EQ(floats->cloud.z[0], 1.5F);
  EXPECT_EQ(floats->cloud.x[0], static_cast<float>((0 - 4.5) / 50 * 1.5));
  for (const std::size_t i : {1U, 2U, 3U, 4U}) EXPECT_TRUE(std::isnan(floats->cloud.z[i]));
  EXPECT_EQ(floats->cloud.z[5], 65535);
  ASSERT_EQ(floats->warnings.size(), 1U);
  EXPECT_THAT(floats->warnings[0].message, testing::HasSubstr("1 of 6 pixels are negative"));
  EXPECT_TRUE(decode_rgbd({depth_png(), color_png(), 0.001, kCamera}, {})->warnings.empty());
}

TEST(Rgbd, TheFormatOfADepthImageIsToldFromItsFirstBytes) {
  const auto png = depth_format(depth_png());
  ASSERT_TRUE(png.ok());
  EXPECT_EQ(png->width, 10U);
  EXPECT_EQ(png->height, 7U);
  EXPECT_EQ(png->usual_scale(), 0.001);
  EXPECT_EQ(depth_format("P5 4 3 65535 ").value().usual_scale(), 0.001);
  const auto pfm = depth_format("Pf 4 3 -1 ");
  ASSERT_TRUE(pfm.ok());
  EXPECT_EQ(pfm->width, 4U);
  EXPECT_EQ(pfm->usual_scale(), 1);
  expect_fault(depth_format("nonsense").status(), "the bytes are neither PNG nor PGM nor PFM");
}

/// A color image whose pixel (u, v) is (u, v, 7).
std::string position_png(const ImageSize& size) {
  std::vector<std::uint8_t> rgb;
  for (std::uint32_t v = 0; v < size.height; ++v) {
    for (std::uint32_t u = 0; u < size.width; ++u) {
      for (const std::uint32_t value : {u, v, 7U}) rgb.push_back(static_cast<std::uint8_t>(value));
    }
  }
  return png_file(size.width, size.height, PNG_FORMAT_RGB, rgb.data());
}

TEST(Rgbd, ColorOfAnotherResolutionIsTakenFromTheNearestPixel) {
  const std::string depth = depth_png({4, 2});
  const auto finer = decode(depth, position_png({12, 6}));
  ASSERT_TRUE(finer.ok()) << finer.status();
  for (std::uint32_t i = 0; i < 8; ++i) EXPECT_EQ(finer->rgb[i], pack_rgb(3 * (i % 4) + 1, 3 * (i / 4) + 1, 7));
  const auto coarser = decode(depth, position_png({2, 1}));
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
    EXPECT_TRUE(decode(depth_png({64, 48}), color_png(size)).ok()) << size.width;
  }
  for (const ImageSize& size : {ImageSize{64, 36}, {64, 49}, {48, 64}, {192, 108}, {2, 2}}) {
    expect_fault(decode(depth_png({64, 48}), color_png(size)).status(), "color: it has " + std::to_string(size.width) +
                                                                            " x " + std::to_string(size.height) +
                                                                            " pixels, and the depth image 64 x 48");
  }
}

TEST(Rgbd, ADamagedJpegIsUsedWithAWarning) {
  const std::string jpeg = encode_jpeg(colors_of({10, 7}), 90).value();
  const std::string cut = jpeg.substr(0, jpeg.size() - 2), depth = depth_png();
  const auto decoded = decode_rgbd({depth, cut, 0.001, kCamera}, {});
  ASSERT_TRUE(decoded.ok()) << decoded.status();
  EXPECT_EQ(decoded->cloud.rgb, decode(depth, jpeg).value().rgb);
  ASSERT_EQ(decoded->warnings.size(), 1U);
  EXPECT_EQ(decoded->warnings[0].reason, WarningReason::kImageDamaged);
  EXPECT_THAT(decoded->warnings[0].message, testing::HasSubstr("color: the JPEG is damaged: "));
}

/// The warnings of an empty depth image of this size.
std::vector<Warning> warnings_for(const Intrinsics& camera, const ImageSize& size) {
  const std::string depth = encode_png_gray16(size, depth_of(size)).value();
  return decode_rgbd({depth, "", 0.001, camera}, {}).value().warnings;
}

TEST(Rgbd, IntrinsicsThatHardlyFitTheImageAreMentioned) {
  struct Case {
    Intrinsics camera;
    const char* message;
  };
  for (const Case& c : std::vector<Case>{
           {{640, 640, 319.5, 239.5}, "lies outside; they look like those of an image of 640 x 480"},
           {{131, 131, 39.5, 29.5}, "is far from the middle; they look like those of an image of 80 x 60"},
           {{131, 131, 500, 59.5}, "the principal point (500, 59.5) lies outside"},
           {{131, 131, 79.5, -3}, "the principal point (79.5, -3) lies outside"},
           {{131, 131, 20, 59.5}, "the principal point (20, 59.5) is far from the middle"},
           {{20, 20, 79.5, 59.5}, "mean a field of view of 152 x 143 degrees"},
           {{5000, 5000, 79.5, 59.5}, "mean a field of view of 1.83 x 1.38 degrees"},
           {{131, 79.5, 85, 59.5}, "differ much; the order is fx, fy, cx, cy"},
       }) {
    const std::vector<Warning> warnings = warnings_for(c.camera, {160, 120});
    ASSERT_EQ(warnings.size(), 1U) << c.message;
    EXPECT_EQ(warnings[0].reason, WarningReason::kIntrinsicsUnlikely);
    EXPECT_THAT(warnings[0].message, testing::HasSubstr("depth: the intrinsics hardly fit an image of 160 x 120"));
    EXPECT_THAT(warnings[0].message, testing::HasSubstr(c.message));
  }
  for (const Intrinsics& camera : std::vector<Intrinsics>{
           {131, 131, 79.5, 59.5}, {131, 130, 84, 55}, {40, 40, 80, 60}, {1500, 1500, 70, 60}, {131, 111, 95, 51}}) {
    EXPECT_TRUE(warnings_for(camera, {160, 120}).empty()) << camera.fx << " " << camera.cx;
  }
}

TEST(Rgbd, TheScaleOfAPfmIsMentioned) {
  struct Case {
    const char* scale;
    double depth_scale;
    bool is_told;
  };
  for (const Case& c : std::vector<Case>{{"-1.0", 0.001, false},
                                         {"-0.001", 0.001, false},
                                         {"-0.001", 1, true},
                                         {"-1000", 1, true},
                                         {"1", 1, false}}) {
    const std::string depth = std::string("Pf 1 1 ") + c.scale + " " + std::string(4, '\0');
    const auto decoded = decode_rgbd({depth, "", c.depth_scale, {1, 1, 0, 0}}, {});
    ASSERT_TRUE(decoded.ok()) << decoded.status();
    ASSERT_EQ(decoded->warnings.size(), c.is_told ? 1U : 0U) << c.scale;
    if (!c.is_told) continue;
    EXPECT_EQ(decoded->warnings[0].reason, WarningReason::kScaleNotUsed);
    EXPECT_THAT(decoded->warnings[0].message, testing::HasSubstr("a unit of depth is taken as 1 m"));
  }
}

TEST(Rgbd, DepthMayBeAnArrayOfNumPy) {
  const std::vector<double> meters{1, 2, 0.5, NAN, 3, 4};
  struct Case {
    std::string type, shape, bytes;
    double scale;
  };
  const std::vector<float> singles(meters.begin(), meters.end());
  for (const Case& c : std::vector<Case>{
           {"'<u2'", "(2, 3)", raw<std::uint16_t>({1000, 2000, 500, 0, 3000, 4000}), 0.001},
           {"'>u2'", "(2, 3, 1)", std::string("\x03\xe8\x07\xd0\x01\xf4\0\0\x0b\xb8\x0f\xa0", 12), 0.001},
           {"'<f8'", "(1, 2, 3)", raw(meters), 1},
           {"'<f4'", "(2, 3)", raw(singles), 1},
           {"'<f2'", "(2, 3)", raw<std::uint16_t>({0x3C00, 0x4000, 0x3800, 0x7E00, 0x4200, 0x4400}), 1}}) {
    const std::string file = npy_file(c.type, c.shape, c.bytes);
    const auto format = depth_format(file);
    ASSERT_TRUE(format.ok()) << format.status();
    EXPECT_EQ(format->width, 3U);
    EXPECT_EQ(format->usual_scale(), c.scale) << c.type;
    const auto decoded = decode_rgbd({file, "", c.scale, kCamera}, {});
    ASSERT_TRUE(decoded.ok()) << decoded.status();
    for (const std::size_t i : {0U, 1U, 2U, 4U, 5U}) {
      EXPECT_FLOAT_EQ(decoded->cloud.z[i], static_cast<float>(meters[i])) << c.type;
    }
    EXPECT_TRUE(std::isnan(decoded->cloud.z[3])) << c.type;
  }
  const auto refused = [](const std::string& file) { return decode_rgbd({file, "", 1, kCamera}, {}).status(); };
  expect_fault(refused(npy_file("'<f4'", "(2, 3, 3)", std::string(72, '\0'))), "depth: NPY: its shape is (2, 3, 3)");
  expect_fault(refused(npy_file("'<i4'", "(2, 3)", std::string(24, '\0'))), "depth must be floats, or integers of 16");
  expect_fault(refused(npy_file("'<f4'", "(2, 3)", "")), "depth: NPY: its shape (2, 3) needs 24 bytes");
  expect_over_limit(decode_rgbd({npy_file("'<f4'", "(20000, 20000)", ""), "", 1, kCamera}, {}).status(), "max_points",
                    "depth: 20000 x 20000 pixels exceed the limit");
}

TEST(Rgbd, ImagesOfOtherFormatsAreNamed) {
  expect_fault(decode(std::string("\x76\x2f\x31\x01\2\0\0\0", 8), "").status(), "depth: this is an OpenEXR image");
  expect_fault(decode(depth_png(), std::string("RIFF\x24\0\0\0WEBPVP8 ", 16)).status(), "color: this is a WebP image");
}

TEST(Rgbd, FaultsNameTheImageAndTheNumbers) {
  expect_fault(decode("", color_png()).status(), "depth: the bytes are neither PNG nor PGM nor PFM nor NPY");
  expect_fault(decode(color_png(), color_png()).status(),
               "depth: PNG: it is a color image with 8 bits, but depth must be gray with 16 bits and without alpha");
  const std::vector<std::uint16_t> four(4, 1);
  expect_fault(decode(png_file(2, 1, PNG_FORMAT_GRAY, four.data()), "").status(),
               "depth: PNG: it is gray with 8 bits, but depth needs 16");
  expect_fault(decode(png_file(2, 1, PNG_FORMAT_LINEAR_Y_ALPHA, four.data()), "").status(),
               "depth: PNG: it is a gray image with an alpha channel with 16 bits");
  expect_fault(decode(encode_jpeg(colors_of({10, 7}), 90).value(), "").status(), "depth: a JPEG cannot hold depth");
  expect_fault(decode(std::string("II*\0", 4), "").status(), "depth: TIFF is not read here, only by segctl");
  expect_fault(decode(depth_png(), "nonsense").status(), "color: the bytes are neither PNG nor JPEG nor PPM");
  const std::string depth = depth_png();
  expect_fault(decode_rgbd({depth, "", 0.001, {.fx = 0, .fy = NAN, .cx = INFINITY, .cy = 0}}, {}).status(),
               "fx is 0, which is not a finite number above 0; fy is nan, which is not a finite number above 0; "
               "cx is inf, which is not finite");
  for (const double scale : {0.0, -1.0, double{NAN}, double{INFINITY}}) {
    expect_fault(decode_rgbd({depth, "", scale, kCamera}, {}).status(), "the depth scale is");
  }
  expect_fault(decode_rgbd({depth, "", 5000, kCamera}, {}).status(),
               "the depth scale is 5000, but meters a unit of depth are meant; 5000 units a meter are 0.0002");
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
  expect_flips_survived(depth, damaged_depth);
  expect_flips_survived(png, damaged_color);
  expect_flips_survived(jpeg, damaged_color);
  const std::string pgm = "P5 3 2 65535 abcdefghijkl", text = "P2 3 2 999 1 22 333 4 55 666",
                    pfm = "Pf 1 2 -1 abcdefgh";
  for (const std::string& bytes : {pgm, pfm}) expect_truncations_refused(bytes, damaged_depth);
  for (const std::string& bytes : {pgm, text, pfm}) expect_flips_survived(bytes, damaged_depth);
}

TEST(Rgbd, ItIsStopped) {
  const std::atomic<bool> cancelled = true;
  const StopToken stop(&cancelled);
  const std::string depth = depth_png(), color = color_png();
  EXPECT_TRUE(absl::IsCancelled(decode_rgbd({depth, color, 0.001, kCamera}, {}, stop).status()));
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
    EXPECT_EQ(bits(decoded->cloud.z), bits(cloud.z));
    EXPECT_EQ(decoded->cloud.has_color(), color);
  }
}

TEST(RgbdEncode, TheDeclaredErrorBoundIsTheLargestError) {
  Cloud cloud = camera_cloud(false);
  for (std::size_t i = 0; i < cloud.size(); ++i) cloud.z[i] += 0.0004F * static_cast<float>(i % 3);
  const auto files = encode_rgbd(cloud, {.intrinsics = kCamera});
  ASSERT_TRUE(files.ok()) << files.status();
  const Cloud decoded = decode_rgbd(files->images(), {}).value().cloud;
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
  expect_fault(encode_rgbd(camera_cloud(false), {.depth_scale = 0.00001}).status(), "does not fit into 1 to 65534");
  for (float& x : cloud.x) x = NAN;
  expect_fault(encode_rgbd(cloud).status(), "the points do not determine the camera");
}

}  // namespace
}  // namespace segserve::codec
