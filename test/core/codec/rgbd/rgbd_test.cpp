// SPDX-License-Identifier: Apache-2.0
#include "segserve/codec/rgbd.hpp"

#include <gmock/gmock.h>

#include <atomic>
#include <cmath>
#include <string>
#include <vector>

#include "core/codec/rgbd/depth_image.hpp"
#include "core/codec/rgbd/jpeg_image.hpp"
#include "core/codec/rgbd/png_image.hpp"
#include "test/core/codec/rgbd/sample_images.hpp"
#include "test/core/codec/support/damaged_bytes.hpp"
#include "test/core/codec/support/image_files.hpp"

namespace segserve::codec {
namespace {

TEST(Rgbd, PixelsBecomePointsByThePinholeModel) {
  const auto cloud = decode_images(depth_png(), color_png());
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
  const auto cloud = decode_images(depth_png(), "");
  ASSERT_TRUE(cloud.ok()) << cloud.status();
  EXPECT_FALSE(cloud->has_color());
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

TEST(Rgbd, ImagesOfOtherFormatsAreNamed) {
  expect_fault(decode_images(std::string("\x76\x2f\x31\x01\2\0\0\0", 8), "").status(),
               "depth: this is an OpenEXR image");
  expect_fault(decode_images(depth_png(), std::string("RIFF\x24\0\0\0WEBPVP8 ", 16)).status(),
               "color: this is a WebP image");
}

TEST(Rgbd, FaultsNameTheImageAndTheNumbers) {
  expect_fault(decode_images("", color_png()).status(), "depth: the bytes are neither PNG nor PGM nor PFM nor NPY");
  expect_fault(decode_images(color_png(), color_png()).status(),
               "depth: PNG: it is a color image with 8 bits, but depth must be gray with 16 bits and without alpha");
  const std::vector<std::uint16_t> four(4, 1);
  expect_fault(decode_images(png_file(2, 1, PNG_FORMAT_GRAY, four.data()), "").status(),
               "depth: PNG: it is gray with 8 bits, but depth needs 16");
  expect_fault(decode_images(png_file(2, 1, PNG_FORMAT_LINEAR_Y_ALPHA, four.data()), "").status(),
               "depth: PNG: it is a gray image with an alpha channel with 16 bits");
  expect_fault(decode_images(encode_jpeg(colors_of({10, 7}), 90).value(), "").status(),
               "depth: a JPEG cannot hold depth");
  expect_fault(decode_images(std::string("II*\0", 4), "").status(), "depth: TIFF is not read here, only by segctl");
  expect_fault(decode_images(depth_png(), "nonsense").status(), "color: the bytes are neither PNG nor JPEG nor PPM");
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
  expect_over_limit(decode_images(with_size(depth_png(), 0x7fffffff, 0x7fffffff), "").status(), "max_points",
                    "depth: 2147483647 x 2147483647 pixels exceed the limit");
  expect_over_limit(decode_images(depth_png(), with_size(color_png(), 100'000, 100'000)).status(), "max_points",
                    "color: ");
  expect_fault(decode_images(with_size(depth_png(), 0, 7), "").status(), "0 x 7 pixels are not the size of an image");
  expect_fault(decode_images(with_size(depth_png(), 0x80000000U, 1), "").status(), "are not the size of an image");
  expect_over_limit(decode_images(depth_png(), "", {.max_points = 69}).status(), "max_points", "10 x 7 pixels");
  expect_over_limit(decode_images(depth_png(), "", {.max_bytes = 1000}).status(), "max_bytes", "of 16 bytes exceed");
  std::string jpeg = encode_jpeg(colors_of({10, 7}), 90).value();
  const std::size_t frame = jpeg.find("\xff\xc0");
  ASSERT_NE(frame, std::string::npos);
  for (const std::size_t at : {5U, 6U, 7U, 8U}) jpeg[frame + at] = '\xf0';
  expect_over_limit(decode_images(depth_png(), jpeg).status(), "max_points", "color: 61680 x 61680 pixels");
}

TEST(Rgbd, DamageIsRefusedOrDecodedWithinBounds) {
  const std::string depth = depth_png();
  const std::string png = color_png();
  const std::string jpeg = encode_jpeg(colors_of({10, 7}), 90).value();
  const auto damaged_depth = [](const std::string& bytes) { return decode_images(bytes, "", kDamageLimits); };
  const auto damaged_color = [&](const std::string& bytes) {
    return bytes.empty() ? absl::InvalidArgumentError("no image") : decode_images(depth, bytes, kDamageLimits);
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

TEST(Rgbd, APngIsStoppedAmongItsChunks) {
  constexpr std::size_t kEndOfHeader = 33;
  constexpr int kChunks = 20'000;
  const std::string png = color_png();
  std::string chunks;  // without content, of a kind that readers may leave out
  for (int i = 0; i < kChunks; ++i) chunks += std::string("\0\0\0\0", 4) + "aaAa" + std::string("\0\0\0\0", 4);
  WorkMeter meter;
  const StopToken counted(nullptr, std::nullopt, &meter);
  {
    StopCheck check(counted);
    const auto image = decode_png_color(png.substr(0, kEndOfHeader) + chunks + png.substr(kEndOfHeader), {}, check);
    EXPECT_TRUE(image.ok()) << image.status();
  }
  EXPECT_GT(meter.units(), kChunks);
  const std::atomic<bool> cancelled = true;
  const StopToken stop(&cancelled);
  StopCheck check(stop);
  // The file ends before its pixels, so that only the chunks can hear the stop.
  EXPECT_TRUE(absl::IsCancelled(decode_png_color(png.substr(0, kEndOfHeader) + chunks, {}, check).status()));
}

TEST(Rgbd, ItIsStopped) {
  const std::atomic<bool> cancelled = true;
  const StopToken stop(&cancelled);
  const std::string depth = depth_png(), color = color_png();
  EXPECT_TRUE(absl::IsCancelled(decode_rgbd({depth, color, 0.001, kCamera}, {}, stop).status()));
}

}  // namespace
}  // namespace segserve::codec
