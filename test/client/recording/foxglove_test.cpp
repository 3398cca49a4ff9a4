// SPDX-License-Identifier: Apache-2.0
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>

#include "client/recording/foxglove/foxglove_messages.hpp"
#include "client/recording/foxglove/proto_reader.hpp"

namespace segserve::recording {
namespace {

using testing::ElementsAre;
using std::string_view_literals::operator""sv;

/// A field of bytes, shorter than 128.
std::string field(int number, std::string_view bytes) {
  std::string out{static_cast<char>(number << 3 | 2), static_cast<char>(bytes.size())};
  return out += bytes;
}

/// A cloud of two points of a float x and a color, with a field that this version does not know.
std::string cloud_message(std::string_view pose = "") {
  const std::string x = field(1, "x") + std::string("\x18\x07", 2);  // offset 0 is left out, type FLOAT32
  const std::string red = field(1, "red") + std::string("\x15\x04\0\0\0\x18\x01", 7);
  return field(1, "\x08\x02\x10\x05") + field(2, "lidar") + (pose.empty() ? "" : field(3, pose)) +
         std::string("\x25\x06\0\0\0", 5) + field(5, x) + field(5, red) + field(6, "aaaabbccccdd") + field(15, "new");
}

TEST(FoxgloveCloud, IsReadAsAnUnorganizedCloud) {
  const std::string message = cloud_message();
  const auto cloud = parse_foxglove_cloud(message);
  ASSERT_TRUE(cloud.ok()) << cloud.status();
  EXPECT_EQ(cloud->header.stamp, 2'000'000'005);
  EXPECT_EQ(cloud->header.frame_id, "lidar");
  EXPECT_EQ(cloud->layout.width, 2U);
  EXPECT_EQ(cloud->layout.height, 1U);
  EXPECT_EQ(cloud->layout.point_step, 6U);
  ASSERT_EQ(cloud->layout.fields.size(), 2U);
  EXPECT_EQ(cloud->layout.fields[0].datatype, codec::PointDatatype::kFloat32);
  EXPECT_EQ(cloud->layout.fields[1].name, "red");
  EXPECT_EQ(cloud->layout.fields[1].offset, 4U);
  EXPECT_EQ(cloud->layout.fields[1].datatype, codec::PointDatatype::kUint8) << "the numbers are not those of ROS";
  EXPECT_EQ(cloud->data, "aaaabbccccdd");
  EXPECT_FALSE(cloud->has_pose);
}

TEST(FoxgloveCloud, APoseIsSeenUnlessItMovesNothing) {
  const std::string one("\x21\0\0\0\0\0\0\xf0\x3f", 9);  // w = 1
  EXPECT_FALSE(parse_foxglove_cloud(cloud_message(field(2, one)))->has_pose);
  const std::string moved("\x09\0\0\0\0\0\0\xf0\x3f", 9);  // x = 1
  EXPECT_TRUE(parse_foxglove_cloud(cloud_message(field(1, moved) + field(2, one)))->has_pose);
}

TEST(FoxgloveCloud, OtherPointsLeaveTheRestAsItWas) {
  auto cloud = parse_foxglove_cloud(cloud_message());
  cloud->layout.fields.push_back({"label", 8, codec::PointDatatype::kUint32, 1});
  cloud->layout.point_step = 12;
  const std::string changed = with_points(cloud_message(), cloud->layout, std::string(300, 'p'));
  const auto read = parse_foxglove_cloud(changed);
  ASSERT_TRUE(read.ok()) << read.status();
  EXPECT_EQ(read->header.stamp, 2'000'000'005);
  EXPECT_EQ(read->layout.width, 25U);
  EXPECT_EQ(read->layout.fields[2].datatype, codec::PointDatatype::kUint32);
  EXPECT_EQ(read->layout.fields[1].offset, 4U);
  EXPECT_NE(changed.find("new"), std::string::npos);
}

TEST(FoxgloveCloud, DamageIsRefused) {
  const std::string message = cloud_message();
  EXPECT_FALSE(parse_foxglove_cloud(message.substr(0, message.size() - 2)).ok());
  EXPECT_FALSE(parse_foxglove_cloud(message + field(6, "aaaab")).ok()) << "5 bytes are no points of 6";
  EXPECT_FALSE(parse_foxglove_cloud("\x0b"sv).ok()) << "a group";
  EXPECT_FALSE(parse_foxglove_cloud("\xff\xff\xff\xff\xff\xff\xff\xff\xff\xff\xff"sv).ok()) << "an endless varint";
}

TEST(FoxgloveCalibration, PackedAndSingleNumbersAreRead) {
  const std::string one("\0\0\0\0\0\0\xf0\x3f", 8);
  std::string packed;
  for (int i = 0; i < 9; ++i) packed += one;
  const std::string message = std::string("\x15\x02\0\0\0\x1d\x03\0\0\0", 10) + field(6, packed) + "\x29" + one;
  const auto info = parse_foxglove_calibration(message);
  ASSERT_TRUE(info.ok());
  EXPECT_EQ(info->width, 2U);
  EXPECT_EQ(info->height, 3U);
  EXPECT_THAT(info->k, testing::Each(1.0));
  EXPECT_THAT(info->distortion, ElementsAre(1.0));
  EXPECT_THAT(info->p, testing::Each(0.0));
}

TEST(FoxgloveImages, AreReadByTheirFields) {
  const std::string raw = std::string("\x15\x02\0\0\0\x1d\x01\0\0\0", 10) + field(4, "16UC1") +
                          std::string("\x2d\x04\0\0\0", 5) + field(6, "1234") + field(7, "cam");
  const auto image = parse_foxglove_raw_image(raw);
  ASSERT_TRUE(image.ok());
  EXPECT_EQ(image->width, 2U);
  EXPECT_EQ(image->height, 1U);
  EXPECT_EQ(image->encoding, "16UC1");
  EXPECT_EQ(image->step, 4U);
  EXPECT_EQ(image->data, "1234");
  EXPECT_EQ(image->header.frame_id, "cam");
  const std::string compressed = field(2, "PNG") + field(3, "png") + field(4, "cam");
  EXPECT_EQ(parse_foxglove_compressed_image(compressed)->data, "PNG");
  EXPECT_EQ(parse_foxglove_compressed_image(compressed)->format, "png");
  EXPECT_EQ(parse_foxglove_compressed_image(compressed)->header.frame_id, "cam");
}

}  // namespace
}  // namespace segserve::recording
