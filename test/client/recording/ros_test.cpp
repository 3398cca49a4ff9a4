// SPDX-License-Identifier: Apache-2.0
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "client/recording/ros/point_cloud2.hpp"
#include "client/recording/ros/ros_reader.hpp"
#include "client/recording/ros/ros_writer.hpp"
#include "test/client/recording/recording_files.hpp"

namespace segserve::recording {
namespace {

using std::string_view_literals::operator""sv;

TEST(Cdr, MembersAreAlignedFromBehindTheEncapsulation) {
  RosReader reader("\0\1\0\0\7\0\0\0\2\0\0\0a\0\0\0\0\0\0\0\0\0\0\0\0\0\xf0\x3f"sv, RosWire::kCdr);
  EXPECT_EQ(reader.number<std::uint8_t>(), 7);
  EXPECT_EQ(reader.string(), "a");
  EXPECT_EQ(reader.number<double>(), 1.0) << "at byte 16";
  EXPECT_TRUE(reader.ok());
}

TEST(Cdr, BigEndianAndTheSecondEncodingAreRead) {
  RosReader big("\0\0\0\0\0\0\0\2\0\0\1\0"sv, RosWire::kCdr);
  EXPECT_EQ(big.number<std::uint32_t>(), 2U);
  EXPECT_EQ(big.number<std::uint32_t>(), 256U);
  EXPECT_TRUE(big.ok());
  RosReader second("\0\7\0\0\1\0\0\0\0\0\0\0\0\0\xf0\x3f"sv, RosWire::kCdr);
  second.number<std::uint32_t>();
  EXPECT_EQ(second.number<double>(), 1.0) << "numbers of 8 bytes are aligned to 4";
  EXPECT_FALSE(RosReader("\0\3\0\0"sv, RosWire::kCdr).ok()) << "a parameter list";
}

TEST(Cdr, ClaimsBeyondTheEndGiveNothing) {
  RosReader reader("\0\1\0\0\xff\xff\xff\xff"sv, RosWire::kCdr);
  EXPECT_EQ(reader.octets(), "");
  EXPECT_FALSE(reader.ok());
  RosReader counts("\0\1\0\0\2\0\0\0xxxxxxx"sv, RosWire::kCdr);
  EXPECT_EQ(counts.count(4), 0U) << "7 bytes are not 2 elements of 4";
  EXPECT_FALSE(counts.ok());
}

TEST(Ros1, MembersArePackedAndStringsUnterminated) {
  RosReader reader("\7\1\0\0\0a\2\0"sv, RosWire::kRos1);
  EXPECT_EQ(reader.number<std::uint8_t>(), 7);
  EXPECT_EQ(reader.string(), "a");
  EXPECT_EQ(reader.number<std::uint16_t>(), 2);
  EXPECT_TRUE(reader.ok());
}

/// Two rows of two points, with a gap behind each row.
PointCloud2 sample(std::string& data) {
  data = std::string("AAAABBBB..CCCCDDDD..", 20);
  PointCloud2 cloud;
  cloud.header = {9, -1'500'000'000, "lidar"};
  cloud.layout = {2, 2, {{"x", 0, codec::PointDatatype::kFloat32, 1}}, 4, 10, false};
  cloud.data = data;
  cloud.is_dense = true;
  return cloud;
}

TEST(PointCloud2, IsReadAsItWasWritten) {
  for (const RosWire wire : {RosWire::kCdr, RosWire::kRos1}) {
    std::string data;
    PointCloud2 cloud = sample(data);
    if (wire == RosWire::kRos1) cloud.header.stamp = 1'500'000'000;
    const std::string bytes = encode_point_cloud2(cloud, wire);
    const auto read = parse_point_cloud2(bytes, wire);
    ASSERT_TRUE(read.ok()) << read.status();
    EXPECT_EQ(read->header.stamp, cloud.header.stamp);
    EXPECT_EQ(read->header.frame_id, "lidar");
    EXPECT_EQ(read->header.sequence, wire == RosWire::kRos1 ? 9U : 0U);
    EXPECT_EQ(read->layout.width, 2U);
    EXPECT_EQ(read->layout.row_step, 10U);
    EXPECT_EQ(read->layout.fields[0].name, "x");
    EXPECT_EQ(read->data, data);
    EXPECT_TRUE(read->is_dense);
    for (std::size_t size = 0; size < bytes.size(); ++size) {
      EXPECT_FALSE(parse_point_cloud2(std::string_view(bytes).substr(0, size), wire).ok()) << size;
    }
  }
}

TEST(PointCloud2, LabelsAreAddedBehindTheOtherFields) {
  std::string data;
  const PointCloud2 cloud = sample(data);
  const auto labeled = add_labels(cloud.layout, cloud.data, std::vector<std::uint32_t>{1, 2, 3, 0x01020304});
  ASSERT_TRUE(labeled.ok());
  EXPECT_EQ(labeled->layout.point_step, 8U);
  EXPECT_EQ(labeled->layout.row_step, 16U);
  EXPECT_EQ(labeled->layout.fields.back().name, "label");
  EXPECT_EQ(labeled->layout.fields.back().offset, 4U);
  EXPECT_EQ(labeled->data, "AAAA\1\0\0\0BBBB\2\0\0\0CCCC\3\0\0\0DDDD\4\3\2\1"sv);
}

TEST(PointCloud2, LabelsThatAreThereAreKeptOnce) {
  using Type = codec::PointDatatype;
  const std::string data("AAAA\7\0\0\0", 8);
  for (const Type type : {Type::kUint32, Type::kFloat32}) {
    const codec::StridedLayout layout{1, 1, {{"label", 4, type, 1}}, 8, 8, true};
    const auto labeled = add_labels(layout, data, std::vector<std::uint32_t>{1});
    ASSERT_TRUE(labeled.ok());
    ASSERT_EQ(labeled->layout.fields.size(), 2U);
    EXPECT_EQ(labeled->layout.fields[0].name, "input_label");
    EXPECT_EQ(labeled->layout.fields[1].name, "label");
    EXPECT_EQ(labeled->data, "AAAA\7\0\0\0\0\0\0\1"sv) << "in the byte order of the cloud";

    const auto again = add_labels(labeled->layout, labeled->data, std::vector<std::uint32_t>{2});
    ASSERT_TRUE(again.ok());
    EXPECT_EQ(again->layout.fields.size(), 2U) << "the labels of an earlier run are replaced";
    EXPECT_EQ(again->data, "AAAA\7\0\0\0\0\0\0\2"sv);
  }
  const codec::StridedLayout both{1, 1, {{"input_label", 0, Type::kUint32, 1}, {"label", 4, Type::kFloat32, 1}}, 8, 8};
  const auto labeled = add_labels(both, data, std::vector<std::uint32_t>{1});
  ASSERT_TRUE(labeled.ok());
  EXPECT_EQ(labeled->layout.fields[0].name, "input_label");
  EXPECT_EQ(labeled->layout.fields[1].name, "label_before");
}

}  // namespace
}  // namespace segserve::recording
