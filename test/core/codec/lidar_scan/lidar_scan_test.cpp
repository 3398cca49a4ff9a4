// SPDX-License-Identifier: Apache-2.0
#include "core/codec/lidar_scan/lidar_scan.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <string>
#include <vector>

#include "core/codec/file/known_formats.hpp"
#include "segserve/codec/cloud_file.hpp"
#include "test/core/codec/support/damaged_bytes.hpp"
#include "test/core/codec/support/npy_file.hpp"
#include "test/core/codec/support/sample_cloud.hpp"

namespace segserve::codec {
namespace {

using testing::HasSubstr;

/// Turns of 16 rings, with so many floats for each point: KITTI has 4, and nuScenes 5.
std::vector<float> sweep(std::size_t floats) {
  std::vector<float> values;
  for (int ring = 0; ring < 16; ++ring) {
    for (int step = 0; step < 60; ++step) {
      const float angle = static_cast<float>(step) * 0.1F;
      values.insert(values.end(), {20 * std::cos(angle), 20 * std::sin(angle), static_cast<float>(ring) - 8});
      values.push_back(floats == 4 ? 0.25F : 100);
      if (floats == 5) values.push_back(static_cast<float>(ring));
    }
  }
  return values;
}

TEST(LidarScan, ThoseOfKittiAndNuScenesAreReadInTheFrameOfTheirSensor) {
  for (const std::size_t floats : {4, 5}) {
    const std::vector<float> values = sweep(floats);
    const auto scan = decode_cloud(bytes_of(raw(values)), {}, {.keep_everything = true});
    ASSERT_TRUE(scan.ok()) << scan.status();
    EXPECT_EQ(scan->format, "LiDAR scan");
    ASSERT_EQ(scan->cloud.size(), 960U);
    for (std::size_t i = 0; i < scan->cloud.size(); ++i) {
      ASSERT_EQ(scan->cloud.x[i], values[i * floats]);
      ASSERT_EQ(scan->cloud.z[i], values[i * floats + 2]);
    }
    EXPECT_EQ(scan->cloud.view, View::world(0, 0, 0));
    ASSERT_EQ(scan->attributes.size(), floats - 3);
    EXPECT_EQ(scan->attributes[0].name, "intensity");
    EXPECT_TRUE(scan->warnings.empty());
  }
}

TEST(LidarScan, APointIsNoFormatWithSuchABegin) {
  std::vector<float> values = sweep(4);
  const std::string utf16 = "\xff\xfe";
  std::string file = raw(values);
  file.replace(0, 2, utf16);  // the low bits of the first x
  ASSERT_TRUE(advice_on_format(file));
  EXPECT_TRUE(decode_cloud(bytes_of(file), {}).ok());
}

TEST(LidarScan, OtherBytesAreNone) {
  const std::string file = raw(sweep(4));
  EXPECT_TRUE(is_lidar_scan(file, file.size()));
  EXPECT_TRUE(is_lidar_scan(file.substr(0, 1000), file.size())) << "the begin suffices";
  EXPECT_FALSE(is_lidar_scan(file, file.size() + 1)) << "no whole number of points";
  EXPECT_FALSE(is_lidar_scan(file.substr(0, 15 * 16), 15 * 16)) << "too few points";
  EXPECT_FALSE(is_lidar_scan(std::string(1600, '\0'), 1600));
  EXPECT_FALSE(is_lidar_scan(std::string(1600, ' '), 1600));
  EXPECT_FALSE(is_lidar_scan(std::string(1600, '1'), 1600));
  const std::string doubles = raw(std::vector<double>(800, 1.5));
  EXPECT_FALSE(is_lidar_scan(doubles, doubles.size()));
  for (const float wrong : {NAN, INFINITY, 2000.0F, 1e-9F}) {
    std::vector<float> values = sweep(4);
    for (std::size_t i = 0; i < 10; ++i) values[40 + 4 * i] = wrong;
    EXPECT_FALSE(is_lidar_scan(raw(values), raw(values).size())) << wrong;
  }
  std::vector<float> rings = sweep(5);
  for (std::size_t i = 0; i < 10; ++i) rings[4 + 5 * i] = 0.5F;
  EXPECT_FALSE(is_lidar_scan(raw(rings), raw(rings).size()));
  expect_fault(decode_lidar_scan(bytes_of("nothing"), {}).status(), "no LiDAR scan of KITTI or nuScenes");
}

TEST(LidarScan, AFewOddPointsAreRead) {
  std::vector<float> values = sweep(4);
  std::fill_n(values.begin() + 80, 4, NAN);
  values[120] = 3000;
  values[163] = 1e9F;
  const auto scan = decode_cloud(bytes_of(raw(values)), {});
  ASSERT_TRUE(scan.ok()) << scan.status();
  EXPECT_EQ(scan->cloud.size(), 960U);
  EXPECT_TRUE(std::isnan(scan->cloud.x[20]));
  EXPECT_EQ(scan->cloud.x[30], 3000);
}

TEST(LidarScan, LimitsHold) {
  DecodeLimits limits;
  limits.max_points = 959;
  const auto scan = decode_cloud(bytes_of(raw(sweep(4))), limits);
  EXPECT_TRUE(absl::IsInvalidArgument(scan.status())) << scan.status();
  EXPECT_THAT(std::string(scan.status().message()), HasSubstr("960 points exceed the limit"));
}

}  // namespace
}  // namespace segserve::codec
