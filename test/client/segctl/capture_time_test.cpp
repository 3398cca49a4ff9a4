// SPDX-License-Identifier: Apache-2.0
#include "client/segctl/capture_time.hpp"

#include <gmock/gmock.h>

namespace segserve::segctl {
namespace {

using testing::DoubleNear;
using testing::Optional;

constexpr double kTime = 1305031102.175304;

auto at(double time) { return Optional(DoubleNear(time, 1e-6)); }

TEST(CaptureTime, IsSecondsWithDecimals) {
  EXPECT_THAT(capture_time("1305031102.175304.pcd"), at(kTime));
  EXPECT_THAT(capture_time("cloud_1305031102.175304.ply.gz"), at(kTime));
  EXPECT_THAT(capture_time("0.125.pcd"), at(0.125));
}

TEST(CaptureTime, IsAWholeNumberOfTheLengthOfATime) {
  EXPECT_THAT(capture_time("1305031102175.pcd"), at(1305031102.175));
  EXPECT_THAT(capture_time("lidar-1305031102175304.pcd"), at(kTime));
  EXPECT_THAT(capture_time("1305031102175304000.las"), at(kTime));
}

TEST(CaptureTime, IsNoNumberOfAFrameAndNoVersion) {
  for (const char* name : {"frame_0001.pcd", "000123.bin", "scene.pcd", "cloud.1.25.pcd", "1305031102.pcd", "",
                           "1305031102175304_left.pcd", "1305031102.175304left.pcd", "12345678901234567890.pcd"}) {
    EXPECT_EQ(capture_time(name), std::nullopt) << name;
  }
}

}  // namespace
}  // namespace segserve::segctl
