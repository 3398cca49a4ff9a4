// SPDX-License-Identifier: Apache-2.0
#include "segserve/codec/planar.hpp"

#include "test/core/codec/support/sample_cloud.hpp"

namespace segserve::codec {
namespace {

TEST(Planar, KeepsEverything) {
  for (const bool color : {false, true}) {
    const Sample sample = make_sample(1, 13, 7, color, false);
    const PlanarPlanes planes = encode_planar(sample.cloud);
    EXPECT_EQ(planes.x.size(), 4U * 13 * 7);
    auto read = decode_planar(planes, 13, 7, View::world(1, 2, 3), DecodeLimits{});
    ASSERT_TRUE(read.ok()) << read.status();
    const CloudView& view = *read;
    EXPECT_EQ(view.width, 13U);
    EXPECT_EQ(view.height, 7U);
    EXPECT_EQ(view.view, View::world(1, 2, 3));
    expect_same_points((*std::move(read)).to_cloud(), sample.cloud);
  }
}

TEST(Planar, LayoutIsLittleEndianFloatsAndInterleavedBytes) {
  const Cloud cloud{{1.0F}, {-2.0F}, {0.5F}, {0x102030}, 1, 1, View::camera()};
  const PlanarPlanes planes = encode_planar(cloud);
  EXPECT_EQ(planes.x, std::string("\x00\x00\x80\x3f", 4));
  EXPECT_EQ(planes.y, std::string("\x00\x00\x00\xc0", 4));
  EXPECT_EQ(planes.z, std::string("\x00\x00\x00\x3f", 4));
  EXPECT_EQ(planes.rgb, "\x10\x20\x30");
}

TEST(Planar, AlignedCoordinatesAreNotCopied) {
  const Sample sample = make_sample(1, 13, 7, true, false);
  const PlanarPlanes planes = encode_planar(sample.cloud);
  std::string unaligned = " " + planes.y;
  PlanarBytes bytes = planes;
  bytes.y = std::string_view(unaligned).substr(1);
  auto read = decode_planar(bytes, 13, 7, View::camera(), {}).value();
  EXPECT_EQ(static_cast<const void*>(read->x.data()), planes.x.data());
  EXPECT_NE(static_cast<const void*>(read->y.data()), bytes.y.data());
  BorrowingCloud moved = std::move(read);
  EXPECT_EQ(moved->rgb.size(), sample.cloud.size());
  const Cloud own = std::move(moved).to_cloud();
  EXPECT_NE(static_cast<const void*>(own.x.data()), planes.x.data());
  expect_same_points(own, sample.cloud);
}

TEST(Planar, EncodingInPlaceGivesTheSameBytes) {
  for (const std::uint32_t points : {0U, 1U, 2U, 91U}) {
    Cloud cloud = make_sample(1, 91, 1, true, false).cloud;
    cloud.resize(points, true);
    std::unique_ptr<char[]> rgb;
    const PlanarBytes in_place = encode_planar_in_place(cloud, rgb);
    const PlanarPlanes copied = encode_planar(cloud);
    EXPECT_EQ(in_place.x, copied.x);
    EXPECT_EQ(in_place.z, copied.z);
    EXPECT_EQ(in_place.rgb, copied.rgb);
    for (std::size_t i = 0; i < points; ++i) {
      ASSERT_EQ(in_place.rgb.substr(3 * i, 3),
                (std::string{static_cast<char>(red(cloud.rgb[i])), static_cast<char>(green(cloud.rgb[i])),
                             static_cast<char>(blue(cloud.rgb[i]))}));
    }
  }
}

TEST(Planar, WrongLengthsAndLimitsAreNamed) {
  const PlanarPlanes good = encode_planar(make_sample(1, 4, 2, true, false).cloud);
  const auto status = [](const PlanarBytes& planes, DecodeLimits limits = {}, std::uint32_t width = 4) {
    return decode_planar(planes, width, 2, View::camera(), limits).status();
  };
  expect_fault(status({good.x.substr(1), good.y, good.z, good.rgb}),
               "plane x has 31 bytes, but 8 points of 4 bytes are needed");
  expect_fault(status({good.x, "", good.z, good.rgb}), "plane y has 0 bytes");
  expect_fault(status({good.x, good.y, good.rgb, good.rgb}), "plane z has 24 bytes");
  expect_fault(status({good.x, good.y, good.z, good.x}), "plane rgb has 32 bytes, but 8 points of 3 bytes are needed");
  expect_over_limit(status(good, {.max_points = 7}), "max_points", "8 points exceed the limit of 7 points");
  expect_over_limit(status(good, {.max_bytes = 119}), "max_bytes", "120 bytes exceed the limit of 119 bytes");
  expect_fault(status(good, {}, 0xFFFFFFFFU), "8589934590 points exceed the limit");
  expect_fault(decode_planar(good, 0xFFFFFFFFU, 0xFFFFFFFFU, View::camera(),
                             {.max_points = std::numeric_limits<std::uint64_t>::max()})
                   .status(),
               "plane x");
  // 2^62 points of 4 bytes are 0 bytes modulo 2^64.
  expect_fault(
      decode_planar({}, 1U << 31U, 1U << 31U, View::camera(), {.max_points = std::numeric_limits<std::uint64_t>::max()})
          .status(),
      "plane x has 0 bytes");
}

}  // namespace
}  // namespace segserve::codec
