// SPDX-License-Identifier: Apache-2.0
#include "core/codec/rgbd/npy_depth.hpp"

#include <gmock/gmock.h>

#include <cmath>
#include <cstdint>
#include <string>
#include <vector>

#include "segserve/codec/rgbd.hpp"
#include "test/core/codec/rgbd/sample_images.hpp"
#include "test/core/codec/support/npy_file.hpp"

namespace segserve::codec {
namespace {

TEST(Rgbd, DepthMayBeAnArrayOfNumPy) {
  const std::vector<double> meters{1, 2, 0.5, NAN, 3, 4};
  struct Case {
    std::string type, shape, bytes;
    double scale;
  };
  const std::vector<float> singles(meters.begin(), meters.end());
  for (const Case& c : std::vector<Case>{
           {"'<u2'", "(2, 3)", raw<std::uint16_t>({1000, 2000, 500, 0, 3000, 4000}), 0.001},
           {"'>u2'", "(2, 3, 1)", std::string("\x03\xe8\x07\xd0\x01\xf4\0\0\x0b\xb8\x0f\xa0", 12), 0.001},
           {"'<f8'", "(1, 2, 3)", raw(meters), 1},
           {"'<f4'", "(2, 3)", raw(singles), 1},
           {"'<f2'", "(2, 3)", raw<std::uint16_t>({0x3C00, 0x4000, 0x3800, 0x7E00, 0x4200, 0x4400}), 1}}) {
    const std::string file = npy_file(c.type, c.shape, c.bytes);
    const auto format = depth_format(file);
    ASSERT_TRUE(format.ok()) << format.status();
    EXPECT_EQ(format->width, 3U);
    EXPECT_EQ(format->usual_scale(), c.scale) << c.type;
    const auto decoded = decode_rgbd({file, "", c.scale, kCamera}, {});
    ASSERT_TRUE(decoded.ok()) << decoded.status();
    for (const std::size_t i : {0U, 1U, 2U, 4U, 5U}) {
      EXPECT_FLOAT_EQ(decoded->cloud.z[i], static_cast<float>(meters[i])) << c.type;
    }
    EXPECT_TRUE(std::isnan(decoded->cloud.z[3])) << c.type;
  }
  const auto refused = [](const std::string& file) { return decode_rgbd({file, "", 1, kCamera}, {}).status(); };
  expect_fault(refused(npy_file("'<f4'", "(2, 3, 3)", std::string(72, '\0'))), "depth: NPY: its shape is (2, 3, 3)");
  expect_fault(refused(npy_file("'<i4'", "(2, 3)", std::string(24, '\0'))), "depth must be floats, or integers of 16");
  expect_fault(refused(npy_file("'<f4'", "(2, 3)", "")), "depth: NPY: its shape (2, 3) needs 24 bytes");
  expect_over_limit(decode_rgbd({npy_file("'<f4'", "(20000, 20000)", ""), "", 1, kCamera}, {}).status(), "max_points",
                    "depth: 20000 x 20000 pixels exceed the limit");
}

}  // namespace
}  // namespace segserve::codec
