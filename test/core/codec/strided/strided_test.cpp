// SPDX-License-Identifier: Apache-2.0
#include "segserve/codec/strided.hpp"

#include <algorithm>
#include <chrono>
#include <cstring>
#include <utility>

#include "test/core/codec/support/sample_cloud.hpp"

namespace segserve::codec {
namespace {

using Type = PointDatatype;

std::string big_endian(std::string data) {
  for (std::size_t i = 0; i + 4 <= data.size(); i += 4) std::reverse(data.begin() + i, data.begin() + i + 4);
  return data;
}

TEST(Strided, KeepsEverything) {
  for (const bool color : {false, true}) {
    const Sample sample = make_sample(1, 13, 7, color, false);
    const StridedCloud strided = encode_strided(sample.cloud);
    EXPECT_EQ(strided.data.size(), strided.layout.bytes());
    const auto read = decode_strided(strided.layout, strided.data, {.view = View::world(1, 2, 3)}, {});
    ASSERT_TRUE(read.ok()) << read.status();
    expect_same_points(read->cloud, sample.cloud);
    EXPECT_EQ(read->cloud.width, 13U);
    EXPECT_EQ(read->cloud.height, 7U);
    EXPECT_EQ(read->cloud.view, View::world(1, 2, 3));
  }
}

TEST(Strided, ReadsBigEndian) {
  const Sample sample = make_sample(2, 5, 4, true, false);
  StridedCloud strided = encode_strided(sample.cloud);
  strided.layout.is_bigendian = true;
  const auto read = decode_strided(strided.layout, big_endian(strided.data), {.view = View::camera()}, {});
  ASSERT_TRUE(read.ok()) << read.status();
  expect_same_points(read->cloud, sample.cloud);
}

/// A layout that depth cameras of ROS send: points of 32 bytes with gaps, padded rows, and a field without a meaning.
TEST(Strided, ReadsTheLayoutOfADepthCamera) {
  const StridedLayout layout{.width = 2,
                             .height = 2,
                             .fields = {{"x", 0, Type::kFloat32, 1},
                                        {"y", 4, Type::kFloat32, 1},
                                        {"z", 8, Type::kFloat32, 0},
                                        {"rgb", 16, Type::kFloat32, 1},
                                        {"covariance", 20, Type::kUint16, 6}},
                             .point_step = 32,
                             .row_step = 70,
                             .is_bigendian = false};
  std::string data(layout.bytes(), '\xee');
  for (std::uint32_t i = 0; i < 4; ++i) {
    char* point = data.data() + i / 2 * 70 + i % 2 * 32;
    const float xyz[] = {1.0F + static_cast<float>(i), 2.0F, 3.0F};
    const std::uint32_t argb = 0xff102030U + i;  // As a float it is a NaN.
    std::memcpy(point, xyz, sizeof(xyz));
    std::memcpy(point + 16, &argb, sizeof(argb));
  }
  const auto read = decode_strided(layout, data, {.view = View::camera()}, {});
  ASSERT_TRUE(read.ok()) << read.status();
  EXPECT_EQ(read->cloud.x, (std::vector<float>{1, 2, 3, 4}));
  EXPECT_EQ(read->cloud.y, (std::vector<float>{2, 2, 2, 2}));
  EXPECT_EQ(read->cloud.z, (std::vector<float>{3, 3, 3, 3}));
  EXPECT_EQ(read->cloud.rgb, (std::vector<std::uint32_t>{0x102030, 0x102031, 0x102032, 0x102033}));
}

TEST(Strided, ReadsDoublesAndSeparateChannels) {
  const StridedLayout layout{.width = 1,
                             .height = 1,
                             .fields = {{"b", 0, Type::kUint8, 1},
                                        {"r", 1, Type::kUint8, 1},
                                        {"g", 2, Type::kUint8, 1},
                                        {"z", 3, Type::kFloat64, 1},
                                        {"x", 11, Type::kFloat64, 1},
                                        {"y", 19, Type::kFloat64, 1}},
                             .point_step = 27,
                             .row_step = 27,
                             .is_bigendian = false};
  std::string data("\x03\x01\x02", 3);
  for (const double value : {0.5, -2.0, 4.25}) data.append(reinterpret_cast<const char*>(&value), 8);
  const auto read = decode_strided(layout, data, {.view = View::world()}, {});
  ASSERT_TRUE(read.ok()) << read.status();
  EXPECT_EQ(read->cloud.x.at(0), -2.0F);
  EXPECT_EQ(read->cloud.y.at(0), 4.25F);
  EXPECT_EQ(read->cloud.z.at(0), 0.5F);
  EXPECT_EQ(read->cloud.rgb.at(0), 0x010203U);
}

TEST(Strided, ColorsThatCannotBeUsedAreMentioned) {
  StridedCloud strided = encode_strided(make_sample(1, 4, 2, true, false).cloud);
  strided.layout.fields[3].datatype = Type::kUint8;
  const auto read = decode_strided(strided.layout, strided.data, {.view = View::camera()}, {});
  ASSERT_TRUE(read.ok()) << read.status();
  EXPECT_FALSE(read->cloud.has_color());
  ASSERT_EQ(read->warnings.size(), 1U);
  EXPECT_EQ(read->warnings[0].reason, WarningReason::kColorNotUsed);
}

TEST(Strided, RowsWithoutPointsTakeNoTime) {
  StridedLayout layout = encode_strided(make_sample(1, 4, 2, true, false).cloud).layout;
  layout.width = 0;
  layout.height = 0xffffffffU;
  layout.row_step = 0;
  const StopToken stop(nullptr, StopToken::Clock::now() + std::chrono::seconds(1));
  const auto read = decode_strided(layout, "", {.view = View::camera()}, {}, stop);
  ASSERT_TRUE(read.ok()) << read.status();
  EXPECT_EQ(read->cloud.size(), 0U);
  EXPECT_EQ(read->cloud.height, 0xffffffffU);
}

TEST(Strided, ASingleRowNeedsNoStep) {
  const Sample sample = make_sample(1, 5, 1, true, false);
  StridedCloud strided = encode_strided(sample.cloud);
  for (const std::uint32_t step : {0U, 16U, 79U}) {
    strided.layout.row_step = step;
    const auto read = decode_strided(strided.layout, strided.data, {.view = View::camera()}, {});
    ASSERT_TRUE(read.ok()) << read.status();
    expect_same_points(read->cloud, sample.cloud);
    const std::string_view cut = std::string_view(strided.data).substr(1);
    expect_fault(decode_strided(strided.layout, cut, {}, {}).status(),
                 "the data have 79 bytes, but 1 rows of 80 bytes are 80");
    expect_over_limit(check_layout(strided.layout, {.max_bytes = 79}), "max_bytes", "1 rows of 80 bytes exceed");
  }
}

struct Fault {
  StridedLayout layout;
  std::string words;
};

std::vector<Fault> faults() {
  const StridedLayout good = encode_strided(make_sample(1, 4, 2, true, false).cloud).layout;
  std::vector<Fault> all;
  const auto add = [&](std::string words, auto change) {
    Fault fault{good, std::move(words)};
    change(fault.layout);
    all.push_back(std::move(fault));
  };
  add("field 'z' at offset 13 ends at byte 17, beyond point_step 16", [](auto& l) { l.fields[2].offset = 13; });
  add("field 'z' at offset 4294967295", [](auto& l) { l.fields[2].offset = 0xffffffffU; });
  add("field 'more' at offset 8", [](auto& l) { l.fields.push_back({"more", 8, Type::kFloat64, 0xffffffffU}); });
  add("field 'x' has datatype 0", [](auto& l) { l.fields[0].datatype = static_cast<Type>(0); });
  add("field 'x' has datatype 9", [](auto& l) { l.fields[0].datatype = static_cast<Type>(9); });
  add("'x' must be one number for each point", [](auto& l) { l.fields[0].count = 2; });
  add("x, y and z must be there", [](auto& l) { l.fields[1].name = "v"; });
  add("'x' occurs twice", [](auto& l) { l.fields[3].name = "x"; });
  add("row_step 63 is less than 4 points of point_step 16", [](auto& l) { l.row_step = 63; });
  add("row_step 64 is less than 4294967295 points", [](auto& l) { l.width = 0xffffffffU, l.height = 0; });
  add("65 fields; at most 64", [](auto& l) { l.fields.resize(65, l.fields[3]); });
  return all;
}

TEST(Strided, EachFaultOfTheLayoutIsNamed) {
  for (const Fault& fault : faults()) {
    expect_fault(check_layout(fault.layout, {}), fault.words);
    expect_fault(
        decode_strided(fault.layout, std::string(fault.layout.bytes(), ' '), {.view = View::camera()}, {}).status(),
        fault.words);
  }
}

TEST(Strided, DataMustHaveTheSizeOfTheLayout) {
  const StridedCloud strided = encode_strided(make_sample(1, 4, 2, true, false).cloud);
  for (const std::size_t size : {std::size_t{0}, strided.data.size() - 1}) {
    expect_fault(decode_strided(strided.layout, strided.data.substr(0, size), {.view = View::camera()}, {}).status(),
                 "2 rows of 64 bytes are 128");
  }
  expect_fault(decode_strided(strided.layout, strided.data + " ", {.view = View::camera()}, {}).status(), "129 bytes");
}

TEST(Strided, LimitsAreNamedBeforeThereIsAnyData) {
  StridedLayout layout = encode_strided(make_sample(1, 4, 2, true, false).cloud).layout;
  expect_over_limit(check_layout(layout, {.max_points = 7}), "max_points", "8 points exceed the limit of 7");
  expect_over_limit(check_layout(layout, {.max_bytes = 127}), "max_bytes", "exceed the limit of 127 bytes");
  layout.row_step = 0xffffffffU;
  layout.height = 0xffffffffU;
  layout.width = 0;
  expect_over_limit(check_layout(layout, {}), "max_bytes", "4294967295 rows of 4294967295 bytes");
  layout.width = 0xffffffffU;
  expect_over_limit(check_layout(layout, {}), "max_points", "18446744065119617025 points");
}

}  // namespace
}  // namespace segserve::codec
