// SPDX-License-Identifier: Apache-2.0
#include "segserve/codec/draco.hpp"

#include <cmath>
#include <limits>

#include "test/core/codec/support/damaged_bytes.hpp"
#include "test/core/codec/support/sample_cloud.hpp"

namespace segserve::codec {
namespace {

constexpr DecodeLimits kEnabled{.max_points = 100'000, .max_bytes = 2'000'000, .draco = true};

class Draco : public testing::Test {
 protected:
  void SetUp() override {
    if (!draco_is_built()) GTEST_SKIP() << "built without Draco";
  }
};

/// Random points within +-`range` meters. About one in seven is not finite unless `all_finite` is set.
Cloud random_row(std::uint32_t seed, std::uint32_t width, float range, bool color, bool all_finite) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<float> coordinate(-range, range);
  Cloud cloud;
  cloud.resize(width, color);
  cloud.width = width;
  cloud.height = 1;
  for (std::size_t i = 0; i < width; ++i) {
    cloud.x[i] = coordinate(random);
    cloud.y[i] = coordinate(random);
    cloud.z[i] = !all_finite && random() % 7 == 0 ? NAN : coordinate(random);
    if (color) cloud.rgb[i] = random() & 0xFFFFFFU;
  }
  return cloud;
}

absl::StatusOr<Cloud> decode(const DracoFile& file, std::uint32_t width, const DecodeLimits& limits = kEnabled) {
  return decode_draco(file.data, file.finite, width, 1, View::world(), limits);
}

TEST_F(Draco, KeepsOrderColorsAndTheBound) {
  std::uint32_t seed = 0;
  for (const double bound : {0.0001, 0.001, 0.01}) {
    for (const float range : {0.5F, 10.0F, 100.0F}) {
      for (const bool color : {false, true}) {
        ++seed;
        const Cloud cloud = random_row(seed, 3000, range, color, seed % 3 == 0);
        const auto file = encode_draco(cloud, bound);
        ASSERT_TRUE(file.ok()) << file.status();
        const auto decoded = decode(*file, 3000);
        ASSERT_TRUE(decoded.ok()) << decoded.status();
        for (std::size_t i = 0; i < cloud.size(); ++i) {
          const bool finite = is_finite(cloud.x[i], cloud.y[i], cloud.z[i]);
          ASSERT_EQ(is_finite(decoded->x[i], decoded->y[i], decoded->z[i]), finite);
          if (!finite) continue;
          ASSERT_NEAR(decoded->x[i], cloud.x[i], bound);
          ASSERT_NEAR(decoded->y[i], cloud.y[i], bound);
          ASSERT_NEAR(decoded->z[i], cloud.z[i], bound);
          if (color) {
            ASSERT_EQ(decoded->rgb[i], cloud.rgb[i]);
          }
        }
      }
    }
  }
}

TEST_F(Draco, ACloudWithoutFinitePointsIsOnlyABitmap) {
  Cloud cloud = random_row(1, 20, 1, true, true);
  for (float& z : cloud.z) z = NAN;
  const DracoFile file = encode_draco(cloud, 0.001).value();
  EXPECT_TRUE(file.data.empty());
  EXPECT_EQ(file.finite.size(), 3U);
  EXPECT_EQ(decode(file, 20)->size(), 20U);
}

TEST_F(Draco, BoundsThatCannotBeKeptAreRefused) {
  const Cloud cloud = random_row(1, 20, 1000, false, true);
  expect_fault(encode_draco(cloud, 0.00001).status(), "cannot be kept within 1e-05 m");
  expect_fault(encode_draco(cloud, 0).status(), "is not above 0");
}

TEST_F(Draco, IsRefusedUnlessEnabled) {
  const DracoFile file = encode_draco(random_row(1, 20, 1, true, false), 0.001).value();
  EXPECT_EQ(decode(file, 20, {}).status().code(), absl::StatusCode::kFailedPrecondition);
}

TEST_F(Draco, ClaimsAreCheckedBeforeDracoSeesThem) {
  const DracoFile good = encode_draco(random_row(1, 20, 1, true, true), 0.001).value();
  const auto with = [&](std::size_t at, char byte) {
    DracoFile file = good;
    file.data[at] = byte;
    return decode(file, 20).status();
  };
  expect_fault(with(0, 'd'), "do not begin with DRACO");
  expect_fault(with(6, 9), "bitstream 2.9");
  expect_fault(with(7, 1), "it is a mesh");
  expect_fault(with(8, 1), "not sequentially encoded");
  expect_fault(with(10, '\x80'), "flags or metadata");
  expect_fault(with(14, '\x7f'), "it has 2130706452 points, but the cloud has 20");
  expect_fault(with(15, 2), "2 groups of attributes");
  expect_fault(with(16, 3), "3 attributes");
  expect_fault(with(19, '\xff'), "with 255 components");
  expect_over_limit(decode(good, 20, {.max_points = 19, .draco = true}).status(), "max_points", "20 points");
  expect_over_limit(decode(good, 20, {.max_bytes = 299, .draco = true}).status(), "max_bytes", "of 15 bytes");
  expect_fault(decode(good, 21).status(), "it has 20 points, but the cloud has 21");
  expect_fault(decode({good.data, "ab"}, 20).status(), "the bitmap of 20 points has 2 bytes, not 3");
  expect_fault(decode({good.data, std::string(3, '\xff')}, 20).status(), "the bitmap does not mark 20 of 20 points");
}

TEST_F(Draco, DamageIsRefusedOrDecodedWithinBounds) {
  const DracoFile file = encode_draco(random_row(1, 30, 1, true, true), 0.001).value();
  const auto decode_bytes = [](const std::string& bytes) { return decode({bytes, ""}, 30); };
  expect_truncations_refused(file.data, decode_bytes);
  expect_flips_survived(file.data, decode_bytes);
}

}  // namespace
}  // namespace segserve::codec
