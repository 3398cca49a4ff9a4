// SPDX-License-Identifier: Apache-2.0
// Well-formed PLY files, by other programs and by encode_ply.

#include "segserve/codec/ply.hpp"

#include <algorithm>

#include "test/core/codec/support/sample_cloud.hpp"

namespace segserve::codec {
namespace {

using testing::ElementsAre;
using testing::IsEmpty;

LabeledCloud decode(const std::string& file) {
  auto cloud = decode_ply(bytes_of(file), DecodeLimits{});
  EXPECT_TRUE(cloud.ok()) << cloud.status();
  return cloud.value_or(LabeledCloud{});
}

template <typename T>
void put(std::string& out, T value, std::endian order) {
  std::string bytes(reinterpret_cast<const char*>(&value), sizeof value);
  if (order != std::endian::native) std::reverse(bytes.begin(), bytes.end());
  out += bytes;
}

TEST(PlyRoundTrip, KeepsPointsColorsAndLabels) {
  for (const PlyEncoding encoding : {PlyEncoding::kAscii, PlyEncoding::kBinaryLittleEndian}) {
    for (const bool color : {false, true}) {
      for (const bool label : {false, true}) {
        const Sample sample = make_sample(2, 31, 3, color, label);
        const LabeledCloud read = decode(encode_ply(sample.cloud, sample.label, encoding));
        expect_same_points(read.cloud, sample.cloud);
        EXPECT_EQ(read.label, sample.label);
        EXPECT_EQ(read.cloud.width, 93U);
        EXPECT_EQ(read.cloud.height, 1U);
      }
    }
  }
}

TEST(PlyRoundTrip, AnEmptyCloudStaysEmpty) {
  EXPECT_EQ(decode(encode_ply(Cloud{}, {}, PlyEncoding::kAscii)).cloud.size(), 0U);
  EXPECT_EQ(decode(encode_ply(Cloud{}, {}, PlyEncoding::kBinaryLittleEndian)).cloud.size(), 0U);
}

const std::string kTwoVertices = "element vertex 2\nproperty float x\nproperty float y\nproperty float z\n";

TEST(PlyRead, WhatFollowsTheVerticesIsNotNeeded) {
  const std::string ascii = "ply\nformat ascii 1.0\n" + kTwoVertices;
  const std::string faces = "element face 2\nproperty list uchar int vertex_indices\nend_header\n1 2 3\n4 5 6\n";
  EXPECT_THAT(decode(ascii + faces + "3 0 1 0\n3 0 1 0\n").warnings, IsEmpty());
  for (const std::string& file : {ascii + "end_header\n1 2 3\n4 5 6\n7 8 9\n", ascii + faces + "3 0 1 0\n",
                                  ascii + faces + "3 0 1 0 255 0 0\n3 0 1 0 255 0 0\n"}) {
    const LabeledCloud read = decode(file);
    EXPECT_THAT(read.cloud.z, ElementsAre(3, 6));
    ASSERT_EQ(read.warnings.size(), 1U) << file;
    EXPECT_EQ(read.warnings[0].reason, WarningReason::kRowsNotUsed);
  }
}

TEST(PlyRead, LinesMayEndInCarriageReturnsAndBeginWithAByteOrderMark) {
  std::string file = "ply\nformat ascii 1.0\n" + kTwoVertices +
                     "end_header\n\xEF\xBB\xBF"
                     "1 2 3\n4 5 6\n";
  EXPECT_THAT(decode(file).cloud.x, ElementsAre(1, 4));
  EXPECT_THAT(decode("\xEF\xBB\xBF" + file).cloud.x, ElementsAre(1, 4));
  std::ranges::replace(file, '\n', '\r');
  EXPECT_THAT(decode(file).cloud.x, ElementsAre(1, 4));
  // The first byte of the body is that of a line feed, but these lines end in carriage returns.
  std::string binary =
      "ply\rformat binary_little_endian 1.0\relement vertex 1\rproperty char x\rproperty char y\r"
      "property char z\rend_header\r\n\1\2";
  EXPECT_THAT(decode(binary).cloud.x, ElementsAre(10));
}

TEST(PlyRead, IntegersAreCoordinatesAndColorsHaveDecimals) {
  const LabeledCloud read = decode(
      "ply\nformat ascii 1.0\nelement vertex 1\nproperty short x\nproperty int y\nproperty uchar z\n"
      "property uchar Red\nproperty uchar Green\nproperty uchar Blue\nend_header\n-4 5 6 150.0 9.6 7\n");
  EXPECT_THAT(read.cloud.x, ElementsAre(-4));
  EXPECT_THAT(read.cloud.rgb, ElementsAre(0x960A07U));
}

TEST(PlyRead, TextIsReadAsItIsWrittenWhateverTypeIsClaimed) {
  const LabeledCloud read = decode(
      "ply\nformat ascii 1.0\nelement vertex 2\nproperty int x\nproperty int y\nproperty float z\n"
      "property uchar red\nproperty uchar green\nproperty uchar blue\nproperty int label\nend_header\n"
      "1 2 3 0 1 1 2\n0.0067 0.5 0.25 0.588235 0 0 nan\n");
  EXPECT_THAT(read.cloud.x, ElementsAre(1, 0.0067F));
  EXPECT_THAT(read.cloud.y, ElementsAre(2, 0.5F));
  EXPECT_THAT(read.cloud.rgb, ElementsAre(0x00FFFFU, 0x960000U));
  EXPECT_THAT(read.label, ElementsAre(2U, 0U));
}

TEST(PlyRead, VerticesMayHaveOtherNames) {
  for (const std::string_view name : {"vertex", "Vertex", "VERTEX", "vertices", "point", "points"}) {
    const LabeledCloud read =
        decode("ply\nformat ascii 1.0\nelement " + std::string(name) +
               " 2\nproperty float px\nproperty float py\nproperty float pz\nend_header\n1 2 3\n4 5 6\n");
    EXPECT_THAT(read.cloud.y, ElementsAre(2, 5)) << name;
  }
}

TEST(PlyRead, ColorsInATextureAreMentioned) {
  const LabeledCloud read =
      decode("ply\nformat ascii 1.0\ncomment TextureFile a.png\n" + kTwoVertices + "end_header\n1 2 3\n4 5 6\n");
  ASSERT_EQ(read.warnings.size(), 1U);
  EXPECT_EQ(read.warnings[0].reason, WarningReason::kColorNotUsed);
}

TEST(PlyRead, ColorsThatAreWordsAreLeftOutAndMentioned) {
  const LabeledCloud read = decode("ply\nformat ascii 1.0\n" + kTwoVertices +
                                   "property uchar red\nproperty uchar green\nproperty uchar blue\nend_header\n"
                                   "1 2 3 1 2 3\n4 5 6 1 dark 3\n");
  EXPECT_THAT(read.cloud.x, ElementsAre(1, 4));
  EXPECT_FALSE(read.cloud.has_color());
  ASSERT_EQ(read.warnings.size(), 1U);
  EXPECT_EQ(read.warnings[0].message, "the cloud has no color: line 12: 'dark' is not a value of 'green'");
}

TEST(PlyRead, LabelsThatAreWordsAreLeftOutAndMentioned) {
  const LabeledCloud read = decode(
      "ply\nformat ascii 1.0\nelement vertex 2\nproperty float x\nproperty float y\nproperty float z\n"
      "property int label\nend_header\n1 2 3 1\n4 5 6 cup\n");
  EXPECT_THAT(read.cloud.x, ElementsAre(1, 4));
  EXPECT_THAT(read.label, IsEmpty());
  ASSERT_EQ(read.warnings.size(), 1U);
  EXPECT_EQ(read.warnings[0].reason, WarningReason::kLabelNotUsed);
}

TEST(PlyRead, TextWithCommentsListsAndOtherElements) {
  const LabeledCloud read = decode(
      "ply\r\nformat ascii 1.0\r\ncomment made by hand\r\nobj_info num_cols 2\r\n"
      "element face 2\r\nproperty list uchar int vertex_indices\r\nproperty float area\r\n"
      "element vertex 2\r\nproperty double z\r\nproperty list uint8 float weights\r\nproperty float x\r\n"
      "property float y\r\nproperty uchar blue\r\nproperty uchar green\r\nproperty uchar red\r\nproperty int label\r\n"
      "element edge 1\r\nproperty int vertex1\r\nproperty int vertex2\r\nend_header\r\n"
      "3 0 1 0 0.5\r\n0 0.25\r\n"
      "3 2 0.1 0.2 1 2 30 20 10 -1\r\n\r\n6 0 4 5 33 22 11 8\r\n"
      "0 1\r\n");
  EXPECT_THAT(read.cloud.x, ElementsAre(1, 4));
  EXPECT_THAT(read.cloud.y, ElementsAre(2, 5));
  EXPECT_THAT(read.cloud.z, ElementsAre(3, 6));
  EXPECT_THAT(read.cloud.rgb, ElementsAre(0x0A141EU, 0x0B1621U));
  EXPECT_THAT(read.label, ElementsAre(0U, 8U));
}

TEST(PlyRead, BinaryOfBothByteOrdersWithListsBeforeAndAmongTheVertices) {
  for (const std::endian order : {std::endian::little, std::endian::big}) {
    std::string file = std::string("ply\nformat binary_") + (order == std::endian::big ? "big" : "little") +
                       "_endian 1.0\nelement face 2\nproperty list ushort int vertex_indices\n"
                       "element vertex 2\nproperty uchar diffuse_red\nproperty uchar diffuse_green\n"
                       "property uchar diffuse_blue\nproperty double x\nproperty list int8 double weights\n"
                       "property float y\nproperty float z\nproperty float scalar_Label\nend_header\n";
    for (std::uint16_t length = 3; length <= 4; ++length) {
      put(file, length, order);
      for (std::int32_t i = 0; i < length; ++i) put(file, i, order);
    }
    for (int i = 0; i < 2; ++i) {
      file += std::string("\x01\x02", 2) + static_cast<char>(3 + i);
      put(file, 1.5 + i, order);
      put(file, static_cast<std::int8_t>(i), order);
      for (int k = 0; k < i; ++k) put(file, 9.0, order);
      put(file, 2.5F, order);
      put(file, 3.5F, order);
      put(file, 20.0F, order);
    }
    const LabeledCloud read = decode(file);
    EXPECT_THAT(read.cloud.x, ElementsAre(1.5F, 2.5F));
    EXPECT_THAT(read.cloud.y, ElementsAre(2.5F, 2.5F));
    EXPECT_THAT(read.cloud.z, ElementsAre(3.5F, 3.5F));
    EXPECT_THAT(read.cloud.rgb, ElementsAre(0x010203U, 0x010204U));
    EXPECT_THAT(read.label, ElementsAre(20U, 20U));
  }
}

TEST(PlyRead, BytesBehindTheLastElementAreMentionedIfTheyAreRows) {
  std::string file = "ply\nformat binary_little_endian 1.0\n" + kTwoVertices + "end_header\n";
  for (int i = 0; i < 6; ++i) put(file, 1.0F, std::endian::little);
  EXPECT_THAT(decode(file + "\n").warnings, IsEmpty());
  EXPECT_THAT(decode(file + std::string(64, '\0')).warnings, IsEmpty());
  const LabeledCloud read = decode(file + "twelve bytes");
  EXPECT_THAT(read.cloud.x, ElementsAre(1, 1));
  ASSERT_EQ(read.warnings.size(), 1U);
  EXPECT_EQ(read.warnings[0].reason, WarningReason::kRowsNotUsed);
  EXPECT_THAT(read.warnings[0].message, testing::HasSubstr("12 bytes, which are 1 rows"));
}

TEST(PlyRead, ListsOfVerticesAreMentioned) {
  const std::string file =
      "ply\nformat ascii 1.0\nelement vertex 1\nproperty float x\nproperty float y\nproperty float z\n"
      "property list uchar int track\nend_header\n1 2 3 2 7 8\n";
  EXPECT_THAT(decode(file).warnings, IsEmpty()) << "nothing is written";
  const auto read = decode_ply(bytes_of(file), DecodeLimits{}, {.keep_everything = true});
  ASSERT_TRUE(read.ok());
  ASSERT_EQ(read->warnings.size(), 1U);
  EXPECT_EQ(read->warnings[0].reason, WarningReason::kAttributeNotKept);
  EXPECT_THAT(read->warnings[0].message, testing::HasSubstr("'track'"));
}

TEST(PlyRead, OtherElementsAreMentionedIfEverythingIsToBeKept) {
  const std::string file =
      "ply\nformat ascii 1.0\nelement vertex 1\nproperty float x\nproperty float y\nproperty float z\n"
      "element face 2\nproperty list uchar int vertex_indices\nelement camera 1\nproperty float view_px\n"
      "element edge 0\nproperty int vertex1\nend_header\n1 2 3\n3 0 0 0\n3 0 0 0\n0.5\n";
  const auto kept = decode_ply(bytes_of(file), {}, {.keep_everything = true});
  ASSERT_TRUE(kept.ok()) << kept.status();
  ASSERT_EQ(kept->warnings.size(), 2U);
  EXPECT_EQ(kept->warnings[0].reason, WarningReason::kAttributeNotKept);
  EXPECT_EQ(kept->warnings[0].message, "the element 'face' is not kept, which has 2 rows");
  EXPECT_EQ(kept->warnings[1].message, "the element 'camera' is not kept, which has 1 row");
  EXPECT_TRUE(decode(file).warnings.empty());
}

TEST(PlyRead, ViewIsWorldWithoutSensorUnlessGiven) {
  const std::string file =
      "ply\nformat ascii 1.0\nelement vertex 2\nproperty float x\nproperty float y\nproperty float z\nend_header\n"
      "1 2 3\n2 3 4\n";
  const LabeledCloud read = decode(file);
  EXPECT_EQ(read.cloud.view, View::world());
  EXPECT_THAT(read.view_rule, testing::StartsWith("WORLD without a sensor"));
  EXPECT_THAT(read.label, IsEmpty());
  const auto given = decode_ply(bytes_of(file), DecodeLimits{}, {.view = View::camera()});
  ASSERT_TRUE(given.ok());
  EXPECT_EQ(given->cloud.view, View::camera());
  EXPECT_EQ(given->view_rule, "CAMERA, as asked for");
}

}  // namespace
}  // namespace segserve::codec
