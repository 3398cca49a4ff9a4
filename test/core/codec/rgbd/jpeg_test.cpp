// SPDX-License-Identifier: Apache-2.0
#include <gmock/gmock.h>

#include <atomic>
#include <cstdlib>

#include "core/codec/rgbd/jpeg_image.hpp"
#include "test/core/codec/support/image_files.hpp"
#include "test/core/codec/support/sample_cloud.hpp"

namespace segserve::codec {
namespace {

using testing::AllOf;
using testing::HasSubstr;

constexpr ImageSize kSize{48, 64};

/// A smooth image, each channel of which changes in its own way.
ColorImage smooth_image() {
  ColorImage image{kSize, {}};
  for (std::uint32_t v = 0; v < kSize.height; ++v) {
    for (std::uint32_t u = 0; u < kSize.width; ++u) {
      for (const std::uint32_t value : {5 * u, 255 - 3 * v, 2 * u + v}) {
        image.rgb.push_back(static_cast<std::uint8_t>(value));
      }
    }
  }
  return image;
}

std::string smooth_jpeg(bool progressive = false) {
  return jpeg_file(kSize, smooth_image().rgb, {.progressive = progressive});
}

absl::StatusOr<JpegImage> jpeg_of(const std::string& bytes, const DecodeLimits& limits = {}) {
  GoOn go_on;
  return decode_jpeg(bytes, limits, go_on.check);
}

/// The largest difference between numbers of the first `count`.
int largest_difference(const std::vector<std::uint8_t>& a, const std::vector<std::uint8_t>& b, std::size_t count) {
  int largest = 0;
  for (std::size_t i = 0; i < count; ++i) largest = std::max(largest, std::abs(a[i] - b[i]));
  return largest;
}

TEST(Jpeg, SequentialAndProgressiveImagesAreReadWithoutDamage) {
  for (const bool progressive : {false, true}) {
    const auto jpeg = jpeg_of(smooth_jpeg(progressive));
    ASSERT_TRUE(jpeg.ok()) << jpeg.status();
    EXPECT_EQ(jpeg->damage, "");
    EXPECT_EQ(jpeg->image.size, kSize);
    EXPECT_LE(largest_difference(jpeg->image.rgb, smooth_image().rgb, 3 * kSize.pixels()), 8);
  }
}

TEST(Jpeg, WhatWasEncodedIsDecoded) {
  const auto jpeg = jpeg_of(encode_jpeg(smooth_image(), 95).value());
  ASSERT_TRUE(jpeg.ok()) << jpeg.status();
  EXPECT_LE(largest_difference(jpeg->image.rgb, smooth_image().rgb, 3 * kSize.pixels()), 16);
  // Noise of the best quality takes more bytes than usual images.
  ColorImage noise{{64, 64}, {}};
  std::uint32_t state = 1;
  for (std::size_t i = 0; i < 3 * noise.size.pixels(); ++i) {
    state = 1664525 * state + 1013904223;
    noise.rgb.push_back(state >> 31U != 0 ? 255 : 0);
  }
  EXPECT_TRUE(jpeg_of(encode_jpeg(noise, 100).value()).ok());
}

TEST(Jpeg, StrayBytesBeforeTheEndAndAMissingEndCostNoPixels) {
  const std::string good = smooth_jpeg();
  const std::string body = good.substr(0, good.size() - 2);
  const auto expected = jpeg_of(good).value().image.rgb;
  for (const std::string& bytes : {body + std::string(12, 'x') + "\xff\xd9", body, body + std::string(40, '\0')}) {
    const auto jpeg = jpeg_of(bytes);
    ASSERT_TRUE(jpeg.ok()) << jpeg.status();
    EXPECT_THAT(jpeg->damage, HasSubstr("all pixels are there"));
    EXPECT_EQ(jpeg->image.rgb, expected);
  }
  const auto surplus = jpeg_of(good + std::string(100, 'x'));
  ASSERT_TRUE(surplus.ok());
  EXPECT_EQ(surplus->image.rgb, expected);
}

TEST(Jpeg, TheFirstLostRowIsTold) {
  const std::string good = smooth_jpeg();
  const auto expected = jpeg_of(good).value().image.rgb;
  const std::size_t scan = good.find("\xff\xda");
  const auto jpeg = jpeg_of(good.substr(0, scan + (good.size() - scan) / 2));
  ASSERT_TRUE(jpeg.ok()) << jpeg.status();
  std::uint32_t row = 0, rows = 0;
  const std::size_t told = jpeg->damage.find("from row");
  ASSERT_NE(told, std::string::npos) << jpeg->damage;
  ASSERT_EQ(std::sscanf(jpeg->damage.c_str() + told, "from row %u of %u on", &row, &rows), 2);
  EXPECT_EQ(rows, kSize.height);
  EXPECT_GE(row, 16U);
  EXPECT_LE(row, 48U);
  // Upsampling looks at the next row of blocks, so that the last row before the loss may differ.
  EXPECT_EQ(largest_difference(jpeg->image.rgb, expected, std::size_t{3} * kSize.width * (row - 1)), 0);
  EXPECT_GT(largest_difference(jpeg->image.rgb, expected, expected.size()), 0);
}

TEST(Jpeg, AProgressiveImageThatEndsEarlyIsCoarse) {
  const std::string good = smooth_jpeg(true);
  const auto jpeg = jpeg_of(good.substr(0, good.size() * 9 / 10));
  ASSERT_TRUE(jpeg.ok()) << jpeg.status();
  EXPECT_THAT(jpeg->damage, HasSubstr("coarser"));
  EXPECT_LE(largest_difference(jpeg->image.rgb, smooth_image().rgb, 3 * kSize.pixels()), 40);
}

TEST(Jpeg, EachTruncationIsRefusedOrTold) {
  for (const bool progressive : {false, true}) {
    const std::string good = smooth_jpeg(progressive);
    for (std::size_t size = 0; size < good.size(); ++size) {
      const auto jpeg = jpeg_of(std::string(good.data(), size));
      if (jpeg.ok()) {
        ASSERT_NE(jpeg->damage, "") << size;
        ASSERT_GT(size, good.find("\xff\xda")) << "no pixel can be known";
      } else {
        ASSERT_EQ(jpeg.status().code(), absl::StatusCode::kInvalidArgument) << size;
      }
    }
    const std::size_t pixels = good.find("\xff\xda") + 20;
    expect_fault(jpeg_of(good.substr(0, pixels)).status(), "JPEG: the bytes end before the first row of pixels");
  }
}

TEST(Jpeg, GrayAndInkBecomeColors) {
  const auto mean_of = [](const std::vector<std::uint8_t>& pixel, const JpegKind& kind) {
    std::vector<std::uint8_t> pixels;
    for (std::size_t i = 0; i < kSize.pixels(); ++i) pixels.insert(pixels.end(), pixel.begin(), pixel.end());
    const auto jpeg = jpeg_of(jpeg_file(kSize, pixels, kind));
    EXPECT_TRUE(jpeg.ok()) << jpeg.status();
    EXPECT_EQ(jpeg->damage, "");
    return std::vector<int>(jpeg->image.rgb.begin(), jpeg->image.rgb.begin() + 3);
  };
  const auto near = [](int red, int green, int blue) {
    const auto channel = [](int value) { return AllOf(testing::Ge(value - 3), testing::Le(value + 3)); };
    return testing::ElementsAre(channel(red), channel(green), channel(blue));
  };
  EXPECT_THAT(mean_of({90}, {JCS_GRAYSCALE, JCS_GRAYSCALE}), near(90, 90, 90));
  // Without Adobe's marker the numbers are ink: no cyan, half of the magenta, all yellow, a fifth of black.
  EXPECT_THAT(mean_of({0, 128, 255, 51}, {JCS_CMYK, JCS_CMYK}), near(204, 102, 0));
  // With it they are what the ink leaves.
  EXPECT_THAT(mean_of({255, 127, 0, 204}, {JCS_CMYK, JCS_CMYK, true}), near(204, 102, 0));
  EXPECT_THAT(mean_of({255, 127, 0, 204}, {JCS_CMYK, JCS_YCCK, true}), near(204, 102, 0));
}

TEST(Jpeg, FramesOfACameraMayLeaveOutTheUsualTables) {
  std::string frame = encode_jpeg(smooth_image(), 95).value();
  const auto expected = jpeg_of(frame).value().image.rgb;
  for (std::size_t at = frame.find("\xff\xc4"); at != std::string::npos; at = frame.find("\xff\xc4")) {
    frame.erase(at, 2 + 256 * static_cast<unsigned char>(frame[at + 2]) + static_cast<unsigned char>(frame[at + 3]));
  }
  const auto jpeg = jpeg_of(frame);
  ASSERT_TRUE(jpeg.ok()) << jpeg.status();
  EXPECT_EQ(jpeg->image.rgb, expected);
}

TEST(Jpeg, ScansWithoutEndAreRefused) {
  const std::string good = smooth_jpeg(true);
  const std::size_t last = good.rfind("\xff\xda");
  const std::string scan = good.substr(last, good.size() - 2 - last);
  std::string many = good.substr(0, last);
  for (int i = 0; i < 200; ++i) many += scan;
  expect_fault(jpeg_of(many + "\xff\xd9").status(), "JPEG: it has more than 100 scans");
}

TEST(Jpeg, CoefficientsCountAsMemory) {
  const DecodeLimits limits{.max_bytes = 4 * kSize.pixels()};
  EXPECT_TRUE(jpeg_of(smooth_jpeg(), limits).ok());
  expect_over_limit(jpeg_of(smooth_jpeg(true), limits).status(), "max_bytes", "JPEG: ");
}

TEST(Jpeg, ItIsStoppedAmongItsMarkers) {
  const std::string jpeg = smooth_jpeg();
  std::string comments;
  for (int i = 0; i < 100'000; ++i) comments += std::string("\xff\xfe\0\2", 4);
  WorkMeter meter;
  const StopToken counted(nullptr, std::nullopt, &meter);
  {
    StopCheck check(counted);
    EXPECT_TRUE(decode_jpeg(jpeg.substr(0, 2) + comments + jpeg.substr(2), {}, check).ok());
  }
  EXPECT_GT(meter.units(), 100'000U);
  const std::atomic<bool> cancelled = true;
  const StopToken stop(&cancelled, std::nullopt);
  StopCheck check(stop);
  // The file ends before its pixels, so that only the markers can hear the stop.
  EXPECT_TRUE(absl::IsCancelled(decode_jpeg(jpeg.substr(0, 2) + comments, {}, check).status()));
}

TEST(Jpeg, ItIsStopped) {
  const std::atomic<bool> cancelled = true;
  const StopToken stop(&cancelled, std::nullopt);
  for (const bool progressive : {false, true}) {
    StopCheck check(stop);
    EXPECT_TRUE(absl::IsCancelled(decode_jpeg(smooth_jpeg(progressive), {}, check).status()));
  }
}

}  // namespace
}  // namespace segserve::codec
