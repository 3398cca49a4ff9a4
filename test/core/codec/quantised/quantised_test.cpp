// SPDX-License-Identifier: Apache-2.0
#include "segserve/codec/quantised.hpp"

#include <cmath>
#include <cstring>
#include <random>

#include "core/codec/common/zstd_block.hpp"
#include "core/codec/quantised/quantised_header.hpp"
#include "test/core/codec/support/damaged_bytes.hpp"
#include "test/core/codec/support/sample_cloud.hpp"

namespace segserve::codec {
namespace {

/// Random points within +-`range` meters. About one in seven is not finite unless `all_finite` is set.
Cloud random_cloud(std::uint32_t seed, std::uint32_t width, std::uint32_t height, float range, bool color,
                   bool all_finite = false) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<float> coordinate(-range, range);
  Cloud cloud;
  cloud.resize(std::size_t{width} * height, color);
  cloud.width = width;
  cloud.height = height;
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    cloud.x[i] = coordinate(random);
    cloud.y[i] = coordinate(random);
    cloud.z[i] = coordinate(random);
    if (color) cloud.rgb[i] = random() & 0xFFFFFFU;
    if (all_finite || random() % 7 != 0) continue;
    (random() % 2 == 0 ? cloud.y : cloud.z)[i] = random() % 2 == 0 ? NAN : INFINITY;
  }
  return cloud;
}

/// The largest error of a coordinate. Expects that the order of the points, which of them are finite, and the colors of
/// the finite ones are the same.
double largest_error(const Cloud& decoded, const Cloud& cloud) {
  EXPECT_EQ(decoded.width, cloud.width);
  EXPECT_EQ(decoded.height, cloud.height);
  EXPECT_EQ(decoded.has_color(), cloud.has_color());
  double largest = 0;
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    const bool finite = is_finite(cloud.x[i], cloud.y[i], cloud.z[i]);
    EXPECT_EQ(is_finite(decoded.x[i], decoded.y[i], decoded.z[i]), finite) << "point " << i;
    if (!finite) continue;
    if (cloud.has_color()) {
      EXPECT_EQ(decoded.rgb[i], cloud.rgb[i]) << "point " << i;
    }
    largest = std::max({largest, std::abs(double{decoded.x[i]} - cloud.x[i]),
                        std::abs(double{decoded.y[i]} - cloud.y[i]), std::abs(double{decoded.z[i]} - cloud.z[i])});
  }
  return largest;
}

TEST(Quantised, NoCoordinateIsFartherThanTheBound) {
  std::uint32_t seed = 0;
  for (const double bound : {0.0001, 0.00037, 0.001, 0.01}) {
    for (const float range : {0.001F, 1.0F, 10.0F, 100.0F}) {
      for (const bool color : {false, true}) {
        const Cloud cloud = random_cloud(++seed, 200, 50, range, color);
        const auto bytes = encode_quantised(cloud, bound);
        ASSERT_TRUE(bytes.ok()) << bytes.status();
        const auto decoded = decode_quantised(*bytes, View::world(), {});
        ASSERT_TRUE(decoded.ok()) << decoded.status();
        EXPECT_EQ(decoded->error_bound, bound);
        EXPECT_EQ(decoded->cloud.view, View::world());
        EXPECT_LE(largest_error(decoded->cloud, cloud), bound) << range;
      }
    }
  }
}

/// Tests coordinates at and next to the borders of cells, where rounding can go wrong.
TEST(Quantised, TheBoundHoldsAtTheBordersOfCells) {
  constexpr double kBound = 0.0001;
  Cloud cloud;
  for (int cell = -300'000; cell <= 300'000; cell += 997) {
    const auto border = static_cast<float>(2 * kBound * cell);
    for (const float value : {std::nextafter(border, -1000.0F), border, std::nextafter(border, 1000.0F)}) {
      cloud.x.push_back(value);
    }
  }
  cloud.y = cloud.z = cloud.x;
  cloud.width = static_cast<std::uint32_t>(cloud.x.size());
  cloud.height = 1;
  const auto decoded = decode_quantised(encode_quantised(cloud, kBound).value(), View::world(), {});
  ASSERT_TRUE(decoded.ok()) << decoded.status();
  EXPECT_LE(largest_error(decoded->cloud, cloud), kBound);
}

TEST(Quantised, APointInFrontOfTheCameraStaysThere) {
  Cloud cloud = random_cloud(1, 10, 1, 0.00001F, false, true);
  for (float& z : cloud.z) z = std::abs(z) + 1e-30F;
  const auto decoded = decode_quantised(encode_quantised(cloud, 0.01).value(), View::camera(), {});
  ASSERT_TRUE(decoded.ok());
  for (const float z : decoded->cloud.z) EXPECT_GT(z, 0.0F);
}

TEST(Quantised, CloudsWhosePointsAreAllFiniteNoneFiniteOrAbsent) {
  for (const bool color : {false, true}) {
    Cloud cloud = random_cloud(1, 31, 3, 1, color, true);
    EXPECT_LE(largest_error(decode_quantised(encode_quantised(cloud, 0.001).value(), {}, {}).value().cloud, cloud),
              0.001);
    for (float& x : cloud.x) x = NAN;
    largest_error(decode_quantised(encode_quantised(cloud, 0.001).value(), {}, {}).value().cloud, cloud);
    cloud.resize(0, color);
    cloud.width = cloud.height = 0;
    EXPECT_EQ(decode_quantised(encode_quantised(cloud, 0.001).value(), {}, {}).value().cloud.size(), 0U);
  }
}

/// Checks the example of core/codec/quantised/FORMAT.md byte by byte.
TEST(Quantised, LayoutIsTheDocumentedOne) {
  Cloud cloud;
  cloud.x = {0.0F, NAN, 0.002F};
  cloud.y = {0.0F, 0.0F, -0.002F};
  cloud.z = {1.0F, 1.0F, 1.0F};
  cloud.rgb = {0x102030, 0xffffff, 0x112033};
  cloud.width = 3;
  cloud.height = 1;
  const std::string bytes = encode_quantised(cloud, 0.001).value();
  EXPECT_EQ(bytes.substr(0, 24), std::string("SEGQ\x01\x00\x01\x00"
                                             "\x03\x00\x00\x00\x01\x00\x00\x00\x02\x00\x00\x00"
                                             "\x01\x01\x02\x00",
                                             24));
  double step = 0;
  double bound = 0;
  std::memcpy(&step, bytes.data() + 24, 8);
  std::memcpy(&bound, bytes.data() + 32, 8);
  EXPECT_EQ(bound, 0.001);
  EXPECT_LT(step, 0.002);
  EXPECT_GT(step, 0.0019995);
  // The cells are x 0, 1; y 0, -2 (the position is just below -1); z 500, 500. The zigzag differences are x 0, 2; y 0,
  // 3; z 1000, 0.
  EXPECT_EQ(zstd_decompress(bytes.substr(40), 15).value(), std::string("\x05"
                                                                       "\x00\x02"
                                                                       "\x00\x03"
                                                                       "\xe8\x00\x03\x00"
                                                                       "\x10\x01\x20\x00\x30\x03",
                                                                       15));
  const Cloud decoded = decode_quantised(bytes, View::camera(), {}).value().cloud;
  EXPECT_EQ(decoded.x[2], static_cast<float>(1.5 * step));
  EXPECT_EQ(decoded.y[2], static_cast<float>(-1.5 * step));
  EXPECT_EQ(decoded.z[2], static_cast<float>(500.5 * step));
  EXPECT_TRUE(std::isnan(decoded.x[1]) && std::isnan(decoded.y[1]) && std::isnan(decoded.z[1]));
  EXPECT_EQ(decoded.rgb, (std::vector<std::uint32_t>{0x102030, 0, 0x112033}));
}

TEST(Quantised, BoundsThatCannotBeKeptAreRefused) {
  const Cloud cloud = random_cloud(1, 10, 1, 1, false);
  for (const double bound : {0.0, 0.00009, 0.011, -0.001, double{NAN}}) {
    expect_fault(encode_quantised(cloud, bound).status(), "is not in [0.0001, 0.01] m");
  }
  Cloud far = cloud;
  far.x[3] = 1e6F;
  far.y[3] = far.z[3] = 0;
  expect_fault(encode_quantised(far, 0.001).status(), "coordinates of 1000000 m cannot be kept within 0.001 m");
}

std::string with_header(const QuantisedHeader& header, const std::string& body) {
  return encode_header(header) + zstd_compress(body, 1).value();
}

TEST(Quantised, LyingHeadersAreRefusedBeforeAllocation) {
  QuantisedHeader header{.width = 0xffffffffU,
                         .height = 0xffffffffU,
                         .finite = 0xffffffffU,
                         .planes = {4, 4, 4},
                         .has_color = true,
                         .step = 0.002,
                         .error_bound = 0.001};
  const auto fault = [&](const std::string& body = {}, DecodeLimits limits = {}) {
    return decode_quantised(with_header(header, body), {}, limits).status();
  };
  expect_over_limit(fault(), "max_points", "18446744065119617025 points exceed");
  expect_over_limit(fault({}, {.max_points = UINT64_MAX, .max_bytes = UINT64_MAX - 1}), "max_bytes",
                    "exceed the limit");
  header.height = 1;
  expect_over_limit(fault({}, {.max_points = 1ULL << 40U, .max_bytes = 1'000'000}), "max_bytes", "exceed the limit");
  header.width = 2'000'000;
  expect_fault(fault(), "4294967295 finite points are more than 2000000 x 1");
  header.finite = 2'000'000;
  expect_fault(fault(), "the frame declares 0 bytes, not the claimed 30000000");
  header.finite = 100;
  expect_fault(fault(std::string(250'000 + 1500, '\0')), "the bitmap does not mark 100 of 2000000 points");
  header.width = header.finite = 1;
  header.planes = {1, 5, 1};
  expect_fault(fault(), "5 byte planes");
  header.planes = {1, 0, 1};
  expect_fault(fault(), "0 byte planes");
  header.planes = {1, 1, 1};
  header.step = 0.0021;
  expect_fault(fault(), "a step of 0.0021 m is not once to twice the error bound of 0.001 m");
  header.step = NAN;
  expect_fault(fault(), "a step of nan m");
  header.error_bound = 1;
  expect_fault(fault(), "an error bound of 1 m is not in");
}

TEST(Quantised, OtherVersionsAndReservedBitsAreRefused) {
  const std::string good = encode_quantised(random_cloud(1, 5, 1, 1, true), 0.001).value();
  std::string bytes = good;
  bytes[4] = 2;
  expect_fault(decode_quantised(bytes, {}, {}).status(), "it has version 2, but only 1 can be read");
  for (const std::size_t reserved : {6U, 7U, 23U}) {
    bytes = good;
    bytes[reserved] = static_cast<char>(bytes[reserved] | 0x40);
    expect_fault(decode_quantised(bytes, {}, {}).status(), "a reserved bit");
  }
  expect_fault(decode_quantised("PNG", {}, {}).status(), "does not begin with SEGQ");
}

TEST(Quantised, DamageIsRefusedOrDecodedWithinBounds) {
  const std::string bytes = encode_quantised(random_cloud(3, 9, 5, 2, true), 0.001).value();
  const auto decode = [](const std::string& damaged) -> absl::StatusOr<Cloud> {
    auto decoded = decode_quantised(damaged, View::camera(), kDamageLimits);
    if (!decoded.ok()) return decoded.status();
    return std::move(decoded->cloud);
  };
  expect_truncations_refused(bytes, decode);
  expect_flips_survived(bytes, decode);
}

}  // namespace
}  // namespace segserve::codec
