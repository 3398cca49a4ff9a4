// SPDX-License-Identifier: Apache-2.0
#include "core/codec/npy/npy.hpp"

#include <atomic>

#include "segserve/codec/cloud_file.hpp"
#include "test/core/codec/support/damaged_bytes.hpp"
#include "test/core/codec/support/npy_file.hpp"
#include "test/core/codec/support/sample_cloud.hpp"

namespace segserve::codec {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;

LabeledCloud read(const std::string& file) {
  auto cloud = decode_cloud(bytes_of(file), {}, {.keep_everything = true});
  EXPECT_TRUE(cloud.ok()) << cloud.status();
  return cloud.ok() ? *std::move(cloud) : LabeledCloud{};
}

TEST(Npy, EveryTypeOfNumbersIsRead) {
  EXPECT_THAT(read(npy_file("'<f4'", "(2, 3)", raw<float>({1, 2, 3, 4, 5, 6}))).cloud.z, ElementsAre(3, 6));
  EXPECT_THAT(read(npy_file("'<f8'", "(2, 3)", raw<double>({1, 2, 3, 4, 5, 6}))).cloud.z, ElementsAre(3, 6));
  EXPECT_THAT(read(npy_file("'<i2'", "(2, 3)", raw<std::int16_t>({1, 2, -3, 4, 5, 6}))).cloud.z, ElementsAre(-3, 6));
  EXPECT_THAT(read(npy_file("'|u1'", "(2, 3)", raw<std::uint8_t>({1, 2, 3, 4, 5, 6}))).cloud.z, ElementsAre(3, 6));
  EXPECT_THAT(read(npy_file("'>i4'", "(1, 3)", std::string("\0\0\0\1\0\0\0\2\0\0\0\3", 12))).cloud.z, ElementsAre(3));
  EXPECT_THAT(read(npy_file("'<f2'", "(1, 3)", raw<std::uint16_t>({0x3C00, 0xC100, 0x0001}))).cloud.y,
              ElementsAre(-2.5F));
  EXPECT_THAT(read(npy_file("'<i8'", "(1L, 3L)", raw<std::int64_t>({1, 2, 3}))).cloud.x, ElementsAre(1));
}

TEST(Npy, ColumnsAndShapesHaveMeaning) {
  const LabeledCloud color = read(npy_file("'<f4'", "(1, 6)", raw<float>({1, 2, 3, 255, 128, 0})));
  EXPECT_THAT(color.cloud.rgb, ElementsAre(pack_rgb(255, 128, 0)));
  std::vector<float> image;
  for (int i = 0; i < 6; ++i) image.insert(image.end(), {static_cast<float>(i), 0, 1});
  const LabeledCloud organized = read(npy_file("'<f4'", "(2, 3, 3)", raw(image)));
  EXPECT_EQ(organized.cloud.width, 3U);
  EXPECT_EQ(organized.cloud.height, 2U);
  EXPECT_THAT(organized.cloud.x, ElementsAre(0, 1, 2, 3, 4, 5));
  const LabeledCloud fortran = read(npy_file("'<f4'", "(2, 3)", raw<float>({1, 4, 2, 5, 3, 6}), true));
  EXPECT_THAT(fortran.cloud.x, ElementsAre(1, 4));
  EXPECT_THAT(fortran.cloud.z, ElementsAre(3, 6));
  EXPECT_EQ(read(npy_file("'<f4'", "(0, 3)", "")).cloud.size(), 0U);
}

TEST(Npy, CoordinatesInTheFirstAxisAreFound) {
  std::vector<float> planes;
  for (int k = 0; k < 6; ++k) {
    for (int i = 0; i < 100; ++i) planes.push_back(static_cast<float>(k < 3 ? 100 * k + i : 40 * k));
  }
  for (const char* shape : {"(6, 100)", "(1, 6, 100)", "(6, 1, 100)"}) {
    const LabeledCloud cloud = read(npy_file("'<f4'", shape, raw(planes)));
    ASSERT_EQ(cloud.cloud.size(), 100U) << shape;
    EXPECT_EQ(cloud.cloud.y[7], 107) << shape;
    EXPECT_EQ(cloud.cloud.rgb[7], pack_rgb(120, 160, 200)) << shape;
    ASSERT_EQ(cloud.warnings.size(), 1U);
    EXPECT_THAT(cloud.warnings[0].message, HasSubstr(std::string("its shape is ") + shape + "; the axis of 6"));
  }
  EXPECT_THAT(
      std::string(
          decode_cloud(bytes_of(npy_file("'<u2'", "(10, 100)", std::string(2000, '\1'))), {}).status().message()),
      HasSubstr("a depth image goes into a PNG or PFM for --depth"));
}

TEST(Npy, FourthNumbersMayBeColorsByTheirBits) {
  const auto points = [](std::uint32_t first, std::uint32_t second) {
    std::string bytes = raw<float>({1, 2, 3}) + raw<std::uint32_t>({first});
    return npy_file("'<f4'", "(2, 4)", bytes + raw<float>({4, 5, 6}) + raw<std::uint32_t>({second}));
  };
  const LabeledCloud zed = read(points(0xFF466E96, 0xFFC83C28));
  EXPECT_THAT(zed.cloud.rgb, ElementsAre(0x966E46U, 0x283CC8U));
  EXPECT_THAT(zed.cloud.x, ElementsAre(1, 4));
  EXPECT_EQ(zed.warnings.size(), 1U);
  EXPECT_THAT(read(points(0x00966E46, 0x00283CC8)).cloud.rgb, ElementsAre(0x966E46U, 0x283CC8U));
  for (const auto& [first, second] : std::vector<std::pair<std::uint32_t, std::uint32_t>>{
           {0x3F800000, 0x00283CC8}, {0, 0}, {0x7FC00000, 0x7FC00000}, {0x3F800000, 0x40000000}}) {
    EXPECT_FALSE(read(points(first, second)).cloud.has_color()) << first << " " << second;
  }
}

TEST(Npy, NamedFieldsAreRead) {
  const std::string type =
      "[(('segserve view world 1 2 3', 'x'), '<f8'), ('y', '<f4'), ('z', '>f4'), ('', '|V2'), ('rgb', '|u1', (3,)), "
      "('label', '<u4'), ('name', '<U2'), ('normal', '<f4', (3,))]";
  std::string element = raw<double>({0.5}) + raw<float>({2}) + std::string("\x40\x40\0\0", 4) + "__" + "\xff\x80" +
                        std::string(1, '\0') + raw<std::uint32_t>({7}) + std::string(8, 'a') + raw<float>({0, 0, 1});
  const LabeledCloud cloud = read(npy_file(type, "(1,)", element));
  EXPECT_THAT(cloud.cloud.x, ElementsAre(0.5F));
  EXPECT_THAT(cloud.cloud.z, ElementsAre(3));
  EXPECT_THAT(cloud.cloud.rgb, ElementsAre(pack_rgb(255, 128, 0)));
  EXPECT_THAT(cloud.label, ElementsAre(7));
  EXPECT_EQ(cloud.cloud.view, View::world(1, 2, 3));
  ASSERT_EQ(cloud.warnings.size(), 1U);
  EXPECT_THAT(cloud.warnings[0].message, HasSubstr("'name' are not kept, because they are no numbers"));
  ASSERT_EQ(cloud.attributes.size(), 2U);
  EXPECT_EQ(cloud.attributes[1].name, "normal");
  EXPECT_EQ(cloud.attributes[1].count, 3U);
}

TEST(Npy, FieldsOfPositionsAndColorsHaveManyNamesInAnyCase) {
  const std::string element = raw<float>({1, 2, 3}) + "\xff\x80" + std::string(1, '\0');
  for (const auto& [position, color] : std::vector<std::pair<std::string, std::string>>{
           {"position", "rgb"}, {"Points", "Colors"}, {"XYZ", "RGB"}, {"xyz", "vertex_colors"}}) {
    const LabeledCloud cloud =
        read(npy_file("[('" + position + "', '<f4', (3,)), ('" + color + "', '|u1', (3,))]", "(1,)", element));
    EXPECT_THAT(cloud.cloud.z, ElementsAre(3)) << position;
    EXPECT_THAT(cloud.cloud.rgb, ElementsAre(pack_rgb(255, 128, 0))) << color;
  }
}

TEST(Npy, EachFaultIsNamed) {
  const std::vector<std::pair<std::string, std::string>> cases{
      {npy_file("'|O'", "(2, 3)", "x"), "its elements are Python objects"},
      {npy_file("'<c8'", "(1, 3)", std::string(24, '\0')), "its elements are no numbers"},
      {npy_file("'<f4'", "(3,)", std::string(12, '\0')), "its shape is (3); points have the shape (N, 3)"},
      {npy_file("'<f4'", "(6, 2)", std::string(48, '\0')), "its shape is (6, 2); the last axis must have 3 to 64"},
      {npy_file("'<f4'", "(4, 3)", std::string(47, '\0')), "its shape (4, 3) needs 48 bytes, but there are 47"},
      {npy_file("'<f4'", "(4611686018427387904, 3)", ""), "but there are 0"},
      {npy_file("[('a', '<f4'), ('y', '<f4')]", "(1,)", std::string(8, '\0')),
       "x, y and z must be there; its fields are"},
      {npy_file("[('x', [('y', '<f4')])]", "(1,)", ""), "has fields of its own"},
      {npy_file("'f4'", "(1, 3)", ""), "'f4' is no type of NumPy"},
      {npy_file("'<f4'", "3", ""), "its header lacks"},
      {npy_file("eval()", "(1, 3)", ""), "its header is not a dictionary of Python"},
      {std::string("\x93NUMPY\4\0xxxx", 12), "version 4 is not known"},
  };
  for (const auto& [file, words] : cases) expect_fault(decode_cloud(bytes_of(file), {}).status(), words);
  const std::string file = npy_file("'|u1'", "(4, 3)", std::string(12, '\1'));
  expect_over_limit(decode_cloud(bytes_of(file), {.max_points = 3}).status(), "max_points", "4 points exceed");
}

TEST(Npy, DamageDoesNoHarm) {
  const auto decode = [](const std::string& bytes) -> absl::StatusOr<Cloud> {
    auto cloud = decode_cloud(bytes_of(bytes), kDamageLimits, {.keep_everything = true});
    if (!cloud.ok()) return cloud.status();
    return cloud->cloud;
  };
  for (const std::string& file :
       {npy_file("[('x', '<f4'), ('y', '<f4'), ('z', '<f2'), ('rgb', '|u1', (3,)), ('label', '<u4')]", "(2, 2)",
                 std::string(68, '\1')),
        npy_file("'<f4'", "(2, 3)", std::string(24, '\1'), true)}) {
    expect_truncations_refused(file, decode);
    expect_flips_survived(file, decode);
  }
}

TEST(Npy, AStopIsHeard) {
  for (const bool fortran : {false, true}) {
    const std::string file = npy_file("'<f4'", "(200000, 3)", std::string(2'400'000, '\0'), fortran);
    const std::atomic<bool> cancelled = true;
    WorkMeter meter;
    const StopToken stop(&cancelled, std::nullopt, &meter);
    EXPECT_EQ(decode_npy(bytes_of(file), {}, {}, stop).status().code(), absl::StatusCode::kCancelled);
    EXPECT_LE(meter.units(), StopToken::kMostWorkAfterStop);
  }
}

}  // namespace
}  // namespace segserve::codec
