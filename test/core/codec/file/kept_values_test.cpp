// SPDX-License-Identifier: Apache-2.0
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "gmock/gmock.h"
#include "segserve/codec/cloud_file.hpp"
#include "segserve/codec/pcd.hpp"
#include "segserve/codec/ply.hpp"

// Tests that the values that a cloud carried in go out with the labels beside them, in the file's coordinates.
namespace segserve::codec {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;

LabeledCloud decode(const std::string& file) {
  auto cloud = decode_cloud(std::as_bytes(std::span(file)), {}, {.keep_everything = true});
  EXPECT_TRUE(cloud.ok()) << cloud.status();
  return cloud.ok() ? *std::move(cloud) : LabeledCloud{};
}

std::vector<std::string> names_of(const LabeledCloud& cloud) {
  std::vector<std::string> names;
  for (const Attribute& attribute : cloud.attributes) names.push_back(attribute.name);
  return names;
}

constexpr const char* kPcd =
    "FIELDS x y z intensity time flags label\nSIZE 8 8 8 4 8 1 4\nTYPE F F F F F U U\nCOUNT 1 1 1 1 1 2 1\n"
    "WIDTH 2\nHEIGHT 1\nVIEWPOINT 389425 5819321 120 1 0 0 0\nPOINTS 2\nDATA ascii\n"
    "389425.125 5819321.5 112 0.5 1700000000.25 1 2 7\n389426.125 5819321.25 112.5 0.25 1700000000.5 3 4 8\n";

TEST(KeptValues, SurviveEveryEncoding) {
  const LabeledCloud first = decode(kPcd);
  ASSERT_THAT(names_of(first), ElementsAre("intensity", "time", "flags", "input_label"));
  const std::vector<std::uint32_t> labels{2, 1};
  const FileContent content = content_of(first, labels);
  for (const std::string& file : {encode_pcd(content, PcdEncoding::kAscii), encode_pcd(content, PcdEncoding::kBinary),
                                  encode_pcd(content, PcdEncoding::kBinaryCompressed)}) {
    const LabeledCloud again = decode(file);
    EXPECT_EQ(again.label, labels);
    EXPECT_EQ(again.file_position, first.file_position);
    EXPECT_EQ(again.placement, first.placement);
    EXPECT_EQ(again.cloud.x, first.cloud.x);
    EXPECT_EQ(again.cloud.view, first.cloud.view);
    ASSERT_THAT(names_of(again), ElementsAre("intensity", "time", "flags", "input_label", "input_label"));
    for (std::size_t i = 0; i < first.attributes.size(); ++i) {
      EXPECT_EQ(again.attributes[i].values, first.attributes[i].values) << first.attributes[i].name;
      EXPECT_EQ(again.attributes[i].type, first.attributes[i].type);
    }
  }
}

TEST(KeptValues, SurvivePly) {
  const LabeledCloud first = decode(kPcd);
  const std::vector<std::uint32_t> labels{2, 1};
  for (const PlyEncoding encoding : {PlyEncoding::kAscii, PlyEncoding::kBinaryLittleEndian}) {
    const LabeledCloud again = decode(encode_ply(content_of(first, labels), encoding));
    EXPECT_EQ(again.label, labels);
    EXPECT_EQ(again.file_position, first.file_position);
    EXPECT_EQ(again.cloud.view, first.cloud.view);
    EXPECT_THAT(names_of(again), ElementsAre("intensity", "time", "flags_0", "flags_1", "input_label", "input_label"));
    EXPECT_EQ(again.attributes[1].values, first.attributes[1].values);
  }
}

TEST(KeptValues, BigEndianPlyIsTurned) {
  const std::string header =
      "ply\nformat binary_big_endian 1.0\nelement vertex 1\nproperty float x\nproperty float y\nproperty float z\n"
      "property ushort intensity\nend_header\n";
  const LabeledCloud cloud = decode(header + std::string(12, '\0') + "\1\2");
  ASSERT_EQ(cloud.attributes.size(), 1U);
  EXPECT_THAT(cloud.attributes[0].values, ElementsAre(std::byte{2}, std::byte{1}));
}

TEST(KeptValues, HarmonicsOfSplatsGoOutAgainBesideTheirColors) {
  const LabeledCloud splats = decode(
      "ply\nformat ascii 1.0\nelement vertex 1\nproperty float x\nproperty float y\nproperty float z\n"
      "property float f_dc_0\nproperty float f_dc_1\nproperty float f_dc_2\nend_header\n1 2 3 0.25 -9 0.5\n");
  ASSERT_EQ(splats.attributes.size(), 3U);
  const std::string file =
      encode_ply(FileContent{.cloud = splats.cloud, .label = {}, .attributes = splats.attributes}, PlyEncoding::kAscii);
  EXPECT_THAT(file, HasSubstr("property float f_dc_1\n"));
  EXPECT_THAT(file, HasSubstr(" 0.25 -9 0.5"));
  EXPECT_EQ(decode(file).cloud.rgb, splats.cloud.rgb);
}

TEST(KeptValues, NumbersOfTextThatExceedTheirTypeAreKept) {
  const LabeledCloud cloud = decode(
      "ply\nformat ascii 1.0\nelement vertex 2\nproperty float x\nproperty float y\nproperty float z\n"
      "property uchar wide\nproperty uchar narrow\nend_header\n1 2 3 300 7\n1 2 3 4 8.0\n");
  EXPECT_TRUE(cloud.warnings.empty());
  ASSERT_EQ(cloud.attributes.size(), 2U);
  EXPECT_EQ(cloud.attributes[0].type, ScalarType::kInt64);
  EXPECT_EQ(cloud.attributes[1].type, ScalarType::kUint8);
  EXPECT_THAT(cloud.attributes[1].values, ElementsAre(std::byte{7}, std::byte{8}));
}

TEST(KeptValues, WordsThatAreNoNumbersAreMentioned) {
  const LabeledCloud pcd =
      decode("FIELDS x y z tag\nSIZE 4 4 4 1\nTYPE F F F U\nWIDTH 1\nHEIGHT 1\nDATA ascii\n1 2 3 red\n");
  const LabeledCloud ply = decode(
      "ply\nformat ascii 1.0\nelement vertex 1\nproperty float x\nproperty float y\nproperty float z\n"
      "property uchar tag\nend_header\n1 2 3 cup\n");
  for (const LabeledCloud& cloud : {pcd, ply}) {
    EXPECT_TRUE(cloud.attributes.empty());
    ASSERT_EQ(cloud.warnings.size(), 1U);
    EXPECT_EQ(cloud.warnings[0].reason, WarningReason::kAttributeNotKept);
    EXPECT_THAT(cloud.warnings[0].message, HasSubstr("'tag'"));
  }
}

TEST(KeptValues, TheSensorIsInTheUnitOfTheFile) {
  const std::string file =
      "FIELDS x y z\nSIZE 4 4 4\nTYPE F F F\nWIDTH 2\nHEIGHT 1\nVIEWPOINT 500 250 1300 1 0 0 0\nDATA ascii\n"
      "0 0 0\n100 200 300\n";
  const ReadOptions millimeters{.unit = LengthUnit::kMillimeter, .keep_everything = true};
  const auto first = decode_cloud(std::as_bytes(std::span(file)), {}, millimeters);
  ASSERT_TRUE(first.ok()) << first.status();
  EXPECT_TRUE(first->cloud.view.sensor->isApprox(Eigen::Vector3f(0.5F, 0.25F, 1.3F)));
  const std::string written = encode_pcd(content_of(*first, {}), PcdEncoding::kAscii);
  EXPECT_THAT(written, HasSubstr("VIEWPOINT 500 250 1300 "));
  const auto again = decode_cloud(std::as_bytes(std::span(written)), {}, millimeters);
  ASSERT_TRUE(again.ok()) << again.status();
  EXPECT_TRUE(again->cloud.view.sensor->isApprox(*first->cloud.view.sensor));
}

TEST(KeptValues, EveryViewSurvives) {
  Cloud cloud;
  cloud.x = {1, 2}, cloud.y = {3, 4}, cloud.z = {5, 6};
  for (const auto& [width, height] : {std::pair{2U, 1U}, {1U, 2U}}) {
    cloud.width = width, cloud.height = height;
    for (const View& view : {View::camera(), View::world(), View::world(0, 0, 0), View::world(1, 2, 3)}) {
      cloud.view = view;
      EXPECT_EQ(decode(encode_pcd(cloud, {}, PcdEncoding::kBinary)).cloud.view, view);
      EXPECT_EQ(decode(encode_ply(cloud, {}, PlyEncoding::kAscii)).cloud.view, view);
    }
  }
}

}  // namespace
}  // namespace segserve::codec
