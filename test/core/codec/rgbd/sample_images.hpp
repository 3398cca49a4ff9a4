// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <gtest/gtest.h>

#include <cstddef>
#include <cstdint>
#include <string>
#include <utility>
#include <vector>

#include "core/codec/rgbd/image_size.hpp"
#include "core/codec/rgbd/png_image.hpp"
#include "segserve/codec/rgbd.hpp"
#include "test/core/codec/support/image_files.hpp"
#include "test/core/codec/support/sample_cloud.hpp"

// Images of depth and of color that the tests of RGB-D share, and the camera that took them.
namespace segserve::codec {

inline constexpr Intrinsics kCamera{.fx = 50, .fy = 40, .cx = 4.5, .cy = 3};

/// Depths in millimeters. Every fifth pixel is 0.
inline std::vector<std::uint16_t> depth_of(const ImageSize& size) {
  std::vector<std::uint16_t> depth(size.pixels());
  for (std::size_t i = 0; i < depth.size(); ++i) depth[i] = i % 5 == 2 ? 0 : static_cast<std::uint16_t>(900 + 7 * i);
  return depth;
}

inline std::string depth_png(const ImageSize& size = {10, 7}) {
  return encode_png_gray16(size, depth_of(size)).value();
}

inline ColorImage colors_of(const ImageSize& size) {
  ColorImage image{size, {}};
  for (std::size_t i = 0; i < 3 * size.pixels(); ++i) image.rgb.push_back(static_cast<std::uint8_t>(60 + i));
  return image;
}

inline std::string color_png(const ImageSize& size = {10, 7}) {
  return png_file(size.width, size.height, PNG_FORMAT_RGB, colors_of(size).rgb.data());
}

/// A color image whose pixel (u, v) is (u, v, 7).
inline std::string position_png(const ImageSize& size) {
  std::vector<std::uint8_t> rgb;
  for (std::uint32_t v = 0; v < size.height; ++v) {
    for (std::uint32_t u = 0; u < size.width; ++u) {
      for (const std::uint32_t value : {u, v, 7U}) rgb.push_back(static_cast<std::uint8_t>(value));
    }
  }
  return png_file(size.width, size.height, PNG_FORMAT_RGB, rgb.data());
}

/// The cloud of these images, whose view must be that of a camera.
inline absl::StatusOr<Cloud> decode_images(const std::string& depth, const std::string& color,
                                           const DecodeLimits& limits = {}) {
  auto decoded = decode_rgbd({depth, color, 0.001, kCamera}, limits);
  if (!decoded.ok()) return decoded.status();
  EXPECT_TRUE(decoded->label.empty());
  EXPECT_EQ(decoded->view_rule, "CAMERA, as RGB-D images are");
  return std::move(decoded->cloud);
}

}  // namespace segserve::codec
