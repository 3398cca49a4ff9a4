// SPDX-License-Identifier: Apache-2.0
#include "core/codec/rgbd/intrinsics_check.hpp"

#include <gmock/gmock.h>

#include <vector>

#include "core/codec/rgbd/png_image.hpp"
#include "segserve/codec/rgbd.hpp"
#include "test/core/codec/rgbd/sample_images.hpp"

namespace segserve::codec {
namespace {

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

}  // namespace
}  // namespace segserve::codec
