// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <bit>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <random>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "absl/status/status.h"
#include "segserve/cloud.hpp"
#include "segserve/codec/decode_limits.hpp"

namespace segserve::codec {

/// A cloud with values that are easily lost in files: NaN, infinities, denormals, negative zero, and colors whose
/// packed float is a NaN.
struct Sample {
  Cloud cloud;
  std::vector<std::uint32_t> label;
};

/// A random cloud, with labels if `label` is set.
inline Sample make_sample(std::uint32_t seed, std::uint32_t width, std::uint32_t height, bool color, bool label) {
  std::mt19937 random(seed);
  const std::vector<float> odd{std::numeric_limits<float>::quiet_NaN(),
                               std::numeric_limits<float>::infinity(),
                               -std::numeric_limits<float>::infinity(),
                               std::numeric_limits<float>::denorm_min(),
                               std::numeric_limits<float>::max(),
                               -0.0F,
                               1e30F};
  const auto coordinate = [&] {
    if (random() % 8 == 0) return odd[random() % odd.size()];
    return static_cast<float>(random()) / 4294967296.0F * 8.0F - 4.0F;
  };
  Sample sample;
  const std::size_t points = std::size_t{width} * height;
  sample.cloud.resize(points, color);
  sample.cloud.width = width;
  sample.cloud.height = height;
  for (std::size_t i = 0; i < points; ++i) {
    sample.cloud.x[i] = coordinate();
    sample.cloud.y[i] = coordinate();
    sample.cloud.z[i] = coordinate();
    if (color) sample.cloud.rgb[i] = i % 5 == 0 ? 0xFFC0FFU : random() & 0xFFFFFFU;
    if (label) sample.label.push_back(random() % 3 == 0 ? static_cast<std::uint32_t>(random()) : random() % 20);
  }
  return sample;
}

inline std::span<const std::byte> bytes_of(std::string_view text) { return std::as_bytes(std::span(text)); }

/// The bits of each float. All NaNs are the same one, because lossless files need not keep more.
inline std::vector<std::uint32_t> bits(std::span<const float> values) {
  std::vector<std::uint32_t> out;
  for (const float v : values) out.push_back(std::isnan(v) ? 0x7fc00000U : std::bit_cast<std::uint32_t>(v));
  return out;
}

inline void expect_same_points(const Cloud& actual, const Cloud& expected) {
  EXPECT_EQ(bits(actual.x), bits(expected.x));
  EXPECT_EQ(bits(actual.y), bits(expected.y));
  EXPECT_EQ(bits(actual.z), bits(expected.z));
  EXPECT_EQ(actual.rgb, expected.rgb);
}

/// Expects INVALID_ARGUMENT whose message is one line that contains `words`.
inline void expect_fault(const absl::Status& status, std::string_view words) {
  const std::string message(status.message());
  EXPECT_EQ(status.code(), absl::StatusCode::kInvalidArgument) << message;
  EXPECT_THAT(message, testing::HasSubstr(std::string(words)));
  EXPECT_THAT(message, testing::Not(testing::HasSubstr("\n")));
}

/// Expects, besides, that callers can tell from the status which limit was exceeded.
inline void expect_over_limit(const absl::Status& status, std::string_view limit, std::string_view words) {
  expect_fault(status, words);
  const auto excess = limit_excess(status);
  ASSERT_TRUE(excess.has_value()) << status;
  EXPECT_EQ(excess->limit, limit);
  EXPECT_GT(excess->actual, excess->allowed);
}

}  // namespace segserve::codec
