// SPDX-License-Identifier: Apache-2.0
#include "segserve/codec/rgbd_encode.hpp"

#include <gmock/gmock.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "test/core/codec/rgbd/sample_images.hpp"

namespace segserve::codec {
namespace {

/// An organized cloud that kCamera sees, with points in front of it.
Cloud camera_cloud(bool color) {
  const auto cloud = decode_images(depth_png({20, 15}), color ? color_png({20, 15}) : "");
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
