// SPDX-License-Identifier: Apache-2.0
// The meaning of the fields of a PCD file, in any order and of any types.

#include <algorithm>
#include <array>
#include <bit>
#include <cstring>

#include "segserve/codec/pcd.hpp"
#include "test/core/codec/support/sample_cloud.hpp"

namespace segserve::codec {
namespace {

using testing::ElementsAre;
using testing::IsEmpty;

std::string header(std::string_view fields, std::string_view size, std::string_view type, std::string_view count,
                   int points, std::string_view data) {
  return "# .PCD v0.7 - Point Cloud Data file format\nVERSION 0.7\nFIELDS " + std::string(fields) + "\nSIZE " +
         std::string(size) + "\nTYPE " + std::string(type) + "\nCOUNT " + std::string(count) + "\nWIDTH " +
         std::to_string(points) + "\nHEIGHT 1\nVIEWPOINT 0 0 0 1 0 0 0\nPOINTS " + std::to_string(points) + "\nDATA " +
         std::string(data) + "\n";
}

template <typename T>
void put(std::string& out, T value) {
  out.append(reinterpret_cast<const char*>(&value), sizeof value);
}

LabeledCloud decode(const std::string& file) {
  auto cloud = decode_pcd(bytes_of(file), DecodeLimits{});
  EXPECT_TRUE(cloud.ok()) << cloud.status();
  return cloud.value_or(LabeledCloud{});
}

TEST(PcdFields, AnyOrderIsReadAndUnknownFieldsAreSkipped) {
  std::string file = header("normal_x z histogram x _ y", "4 8 2 4 1 8", "F F U F U F", "1 1 3 1 4 1", 2, "binary");
  for (int i = 0; i < 2; ++i) {
    put(file, 9.0F);
    put(file, 3.0 + i);
    for (std::uint16_t k = 0; k < 3; ++k) put(file, k);
    put(file, 1.0F + static_cast<float>(i));
    file.append(4, 'p');
    put(file, 2.0 + i);
  }
  const LabeledCloud read = decode(file);
  EXPECT_THAT(read.cloud.x, ElementsAre(1.0F, 2.0F));
  EXPECT_THAT(read.cloud.y, ElementsAre(2.0F, 3.0F));
  EXPECT_THAT(read.cloud.z, ElementsAre(3.0F, 4.0F));
  EXPECT_FALSE(read.cloud.has_color());
  EXPECT_THAT(read.label, IsEmpty());
}

/// The bytes as LZF has them that were not compressed: runs of up to 32, each behind its length.
std::string as_lzf(std::string_view bytes) {
  constexpr std::size_t kLongestRun = 32;
  std::string out;
  for (; !bytes.empty(); bytes.remove_prefix(std::min(kLongestRun, bytes.size()))) {
    const std::string_view run = bytes.substr(0, kLongestRun);
    out += static_cast<char>(run.size() - 1);
    out += run;
  }
  return out;
}

TEST(PcdFields, PaddingMayBeAmongCompressedFieldsOrNot) {
  std::string planes[3];
  for (const float x : {1.0F, 2.0F}) put(planes[0], x);
  planes[1] = std::string(2 * 4, 'p');
  for (const float value : {3.0F, 4.0F, 5.0F, 6.0F}) put(planes[2], value);
  for (const bool has_padding : {false, true}) {
    const std::string body = planes[0] + (has_padding ? planes[1] : "") + planes[2], block = as_lzf(body);
    std::string file = header("x _ y z", "4 1 4 4", "F U F F", "1 4 1 1", 2, "binary_compressed");
    put(file, static_cast<std::uint32_t>(block.size()));
    put(file, static_cast<std::uint32_t>(body.size()));
    const LabeledCloud read = decode(file + block);
    EXPECT_THAT(read.cloud.x, ElementsAre(1.0F, 2.0F)) << has_padding;
    EXPECT_THAT(read.cloud.y, ElementsAre(3.0F, 4.0F)) << has_padding;
    EXPECT_THAT(read.cloud.z, ElementsAre(5.0F, 6.0F)) << has_padding;
  }
}

TEST(PcdFields, PackedFloatIsReinterpretedAndNeverConverted) {
  std::string file = header("x y z rgb", "4 4 4 4", "F F F F", "1 1 1 1", 3, "binary");
  for (const std::uint32_t bits : {0x00102030U, 0xFFC0FFEEU, 0x7FC00000U}) {
    file.append(12, '\0');
    put(file, bits);
  }
  // With an opaque alpha most bright colors are NaNs. Only the quiet NaN 0x7FC00000 means "no color".
  EXPECT_THAT(decode(file).cloud.rgb, ElementsAre(0x102030U, 0xC0FFEEU, 0U));
}

TEST(PcdFields, PackedIntegerIsTheSameWhateverItsNameAndSign) {
  std::string file = header("rgba x y z", "4 4 4 4", "U F F F", "1 1 1 1", 1, "binary");
  put(file, 0x7FC00000U);
  file.append(12, '\0');
  EXPECT_THAT(decode(file).cloud.rgb, ElementsAre(0xC00000U));

  const std::string text =
      header("x y z rgb", "4 4 4 4", "F F F I", "1 1 1 1", 2, "ascii") + "0 0 0 -16711936\n0 0 0 1056816\n";
  EXPECT_THAT(decode(text).cloud.rgb, ElementsAre(0x00FF00U, 0x102030U));
}

TEST(PcdFields, PackedTextOfTypeFloatIsTheBitsOfAFloat) {
  const std::string file = header("x y z rgb", "4 4 4 4", "F F F F", "1 1 1 1", 3, "ascii") +
                           "0 0 0 9.4039548e-38\n0 0 0 nan\n0 0 0 2.3418052e-38\n";
  const std::uint32_t bits = std::bit_cast<std::uint32_t>(9.4039548e-38F);
  EXPECT_THAT(decode(file).cloud.rgb, ElementsAre(bits & 0xFFFFFFU, 0U, 0xFF0000U));
}

TEST(PcdFields, PackedFloatsThatAreWholeNumbersAreTheirValues) {
  const std::string text = header("x y z rgb", "4 4 4 4", "F F F F", "1 1 1 1", 4, "ascii") +
                           "0 0 0 4.2108e+06\n0 0 0 nan\n0 0 0 0\n0 0 0 9858630\n";
  EXPECT_THAT(decode(text).cloud.rgb, ElementsAre(4210800U, 0U, 0U, 9858630U));
  std::string binary = header("x y z rgb", "4 4 4 4", "F F F F", "1 1 1 1", 2, "binary");
  for (const float value : {4210752.0F, 255.0F}) {
    binary.append(12, '\0');
    put(binary, value);
  }
  EXPECT_THAT(decode(binary).cloud.rgb, ElementsAre(0x404040U, 0xFFU));
}

TEST(PcdFields, AColorMayBeOneFieldOfSeveralNumbers) {
  std::string bytes = header("x y z rgba", "4 4 4 1", "F F F U", "1 1 1 4", 2, "binary");
  for (const char* color : {"\x10\x20\x30\xff", "\x01\x02\x03\x04"}) bytes.append(12, '\0').append(color, 4);
  EXPECT_THAT(decode(bytes).cloud.rgb, ElementsAre(0x102030U, 0x010203U));
  const std::string text =
      header("x y z bgr", "4 4 4 4", "F F F F", "1 1 1 3", 2, "ascii") + "0 0 0 0 0 1\n0 0 0 1 0 0\n";
  EXPECT_THAT(decode(text).cloud.rgb, ElementsAre(0xFF0000U, 0x0000FFU));
  const std::string unclear = header("x y z rgb", "4 4 4 1", "F F F U", "1 1 1 4", 1, "ascii") + "0 0 0 16 32 48 255\n";
  EXPECT_THAT(decode(unclear).cloud.rgb, ElementsAre(0x102030U));
  ASSERT_EQ(decode(unclear).warnings.size(), 1U);
  EXPECT_THAT(decode(unclear).warnings[0].message, testing::HasSubstr("'rgb' are taken as red, green, blue"));
}

TEST(PcdFields, PackedColorsThatAreNanAreMentioned) {
  const std::string file = header("x y z rgb", "4 4 4 4", "F F F F", "1 1 1 1", 4, "ascii") +
                           "1 2 3 nan\n1 2 3 -nan\nnan nan nan nan\n1 2 3 2.3418052e-38\n";
  const LabeledCloud read = decode(file);
  EXPECT_THAT(read.cloud.rgb, ElementsAre(0U, 0U, 0U, 0xFF0000U));
  ASSERT_EQ(read.warnings.size(), 1U);
  EXPECT_EQ(read.warnings[0].reason, WarningReason::kColorNotUsed);
  EXPECT_THAT(read.warnings[0].message, testing::HasSubstr("2 of 3 colors are NaN"));
}

TEST(PcdFields, PackedTextOfTypeUnsignedIsAnInteger) {
  const std::string file =
      header("x y z rgb", "4 4 4 4", "F F F U", "1 1 1 1", 2, "ascii") + "0 0 0 4278255360\n0 0 0 255\n";
  EXPECT_THAT(decode(file).cloud.rgb, ElementsAre(0x00FF00U, 0x0000FFU));
}

TEST(PcdFields, ChannelsOfBytesOrFloatsAreClampedAndNanIsBlack) {
  const std::string bytes = header("x y z b g r", "4 4 4 1 2 4", "F F F U I U", "1 1 1 1 1 1", 2, "ascii") +
                            "0 0 0 1 2 3\n0 0 0 255 -7 300\n";
  EXPECT_THAT(decode(bytes).cloud.rgb, ElementsAre(0x030201U, 0xFF00FFU));

  const std::string floats = header("x y z r g b", "4 4 4 4 4 8", "F F F F F F", "1 1 1 1 1 1", 2, "ascii") +
                             "0 0 0 254.6 1e9 -3\n0 0 0 nan inf 16.4\n";
  EXPECT_THAT(decode(floats).cloud.rgb, ElementsAre(0xFFFF00U, 0x00FF10U));
}

TEST(PcdFields, PackedColorIsPreferredToChannels) {
  const std::string file =
      header("r g b rgba x y z", "1 1 1 4 4 4 4", "U U U U F F F", "1 1 1 1 1 1 1", 1, "ascii") + "1 2 3 255 0 0 0\n";
  EXPECT_THAT(decode(file).cloud.rgb, ElementsAre(255U));
}

TEST(PcdFields, ACloudThatLacksAChannelHasNoColor) {
  const std::string file = header("x y z r g", "4 4 4 1 1", "F F F U U", "1 1 1 1 1", 1, "ascii") + "0 0 0 1 2\n";
  EXPECT_FALSE(decode(file).cloud.has_color());
}

TEST(PcdFields, LabelsOfAnyNumberType) {
  const std::string head = "0 0 0 ";
  const auto labels = [&](std::string_view size, std::string_view type, std::string_view a, std::string_view b) {
    return decode(header("x y z label", "4 4 4 " + std::string(size), "F F F " + std::string(type), "1 1 1 1", 2,
                         "ascii") +
                  head + std::string(a) + "\n" + head + std::string(b) + "\n")
        .label;
  };
  EXPECT_THAT(labels("4", "U", "4294967295", "0"), ElementsAre(4294967295U, 0U));
  EXPECT_THAT(labels("4", "I", "7", "-1"), ElementsAre(7U, 0U));
  EXPECT_THAT(labels("1", "U", "255", "3"), ElementsAre(255U, 3U));
  EXPECT_THAT(labels("8", "I", "4294967295", "-5"), ElementsAre(4294967295U, 0U));
  EXPECT_THAT(labels("4", "F", "20", "nan"), ElementsAre(20U, 0U));
}

TEST(PcdFields, OldVersionsAndShortHeadersAreRead) {
  const std::string minimal = "FIELDS x y z\nSIZE 4 4 4\nTYPE F F F\nPOINTS 2\nDATA ascii\n1 2 3\n4 5 6\n";
  EXPECT_THAT(decode(minimal).cloud.y, ElementsAre(2.0F, 5.0F));
  const std::string old =
      "VERSION .5\r\nCOLUMNS x y z\r\nSIZE 4 4 4\r\nTYPE F F F\r\nWIDTH 1\r\nDATA ascii\r\n1 2 +3\r\n";
  EXPECT_THAT(decode(old).cloud.z, ElementsAre(3.0F));
}

TEST(PcdFields, OddHeadersAndCommentsAreRead) {
  const std::string odd =
      "\xEF\xBB\xBFVERSION 7\nFIELDS x y z\nSIZE 4 4 4\nTYPE I I I\nWIDTH 2\nHEIGHT 0\nPOINTS 2\nDATA ascii\n"
      "# one\n1 2 3\n#two\n4 5 6.0\n# end\n";
  const LabeledCloud read = decode(odd);
  EXPECT_THAT(read.cloud.z, ElementsAre(3.0F, 6.0F));
  EXPECT_EQ(read.cloud.height, 1U);
  EXPECT_THAT(read.warnings, IsEmpty());
  const std::string zero = "FIELDS x y z\nSIZE 4 4 4\nTYPE F F F\nWIDTH 2\nHEIGHT 0\nDATA ascii\n1 2 3\n4 5 6\n";
  EXPECT_THAT(decode(zero).cloud.z, ElementsAre(3.0F, 6.0F)) << "without POINTS";
  std::string old_macintosh = "FIELDS x y z\rSIZE 4 4 4\rTYPE F F F\rPOINTS 1\rDATA ascii\r1 2 3\r";
  EXPECT_THAT(decode(old_macintosh).cloud.x, ElementsAre(1.0F));
}

TEST(PcdFields, WhatIsNotUsedIsMentioned) {
  const auto reason_of = [](const std::string& file) {
    const LabeledCloud read = decode(file);
    EXPECT_EQ(read.warnings.size(), 1U) << file;
    return read.warnings.empty() ? WarningReason::kOther : read.warnings[0].reason;
  };
  const std::string three = "0 0 0\n0 0 0\n0 0 0\n";
  EXPECT_EQ(reason_of(header("x y z", "4 4 4", "F F F", "1 1 1", 2, "ascii") + three), WarningReason::kRowsNotUsed);
  const std::string label = header("x y z label", "4 4 4 8", "F F F I", "1 1 1 1", 1, "ascii") + "0 0 0 4294967296\n";
  EXPECT_EQ(reason_of(label), WarningReason::kLabelNotUsed);
  const std::string part = header("x y z label", "4 4 4 4", "F F F I", "1 1 1 1", 1, "ascii") + "0 0 0 1.5\n";
  EXPECT_EQ(reason_of(part), WarningReason::kLabelNotUsed);
  const std::string color = header("x y z rgb", "4 4 4 8", "F F F F", "1 1 1 1", 1, "ascii") + "0 0 0 0.5\n";
  EXPECT_EQ(reason_of(color), WarningReason::kColorNotUsed);
}

TEST(PcdFields, RowsOfBytesBeyondTheHeaderAreMentioned) {
  std::string file = header("x y z", "4 4 4", "F F F", "1 1 1", 1, "binary");
  for (int i = 0; i < 9; ++i) put(file, 1.0F);
  const LabeledCloud read = decode(file);
  EXPECT_EQ(read.cloud.size(), 1U);
  ASSERT_EQ(read.warnings.size(), 1U);
  EXPECT_EQ(read.warnings[0].reason, WarningReason::kRowsNotUsed);
  EXPECT_THAT(read.warnings[0].message, testing::HasSubstr("24 bytes, which are 2 rows"));
}

TEST(PcdFields, TextOfIntegersMayExceedTheirType) {
  const std::string bytes =
      header("x y z r g b", "4 4 4 1 1 1", "F F F I I I", "1 1 1 1 1 1", 1, "ascii") + "0 0 0 200 0 9\n";
  EXPECT_THAT(decode(bytes).cloud.rgb, ElementsAre(0xC80009U));
  const std::string packed = header("x y z rgb", "4 4 4 4", "F F F I", "1 1 1 1", 1, "ascii") + "0 0 0 4279246080\n";
  EXPECT_THAT(decode(packed).cloud.rgb, ElementsAre(4279246080U & 0xFFFFFFU));
}

TEST(PcdFields, TextIsReadAsItIsWrittenWhateverTypeIsClaimed) {
  const std::string file =
      header("x y z r g b label intensity", "4 4 4 1 1 1 4 1", "I I I U U U U U", "1 1 1 1 1 1 1 1", 2, "ascii") +
      "0.25 -0.5 7 0 1 0.6 nan 3\n1 2 3.5 0.2 0 1 4 0.5\n";
  const auto read = decode_pcd(bytes_of(file), DecodeLimits{}, {.keep_everything = true});
  ASSERT_TRUE(read.ok()) << read.status();
  EXPECT_THAT(read->cloud.x, ElementsAre(0.25F, 1.0F));
  EXPECT_THAT(read->cloud.z, ElementsAre(7.0F, 3.5F));
  EXPECT_THAT(read->cloud.rgb, ElementsAre(pack_rgb(0, 255, 153), pack_rgb(51, 0, 255)));
  EXPECT_THAT(read->label, ElementsAre(0U, 4U));
  EXPECT_THAT(read->warnings, IsEmpty());
  ASSERT_EQ(read->attributes.size(), 2U);
  EXPECT_EQ(read->attributes[1].type, ScalarType::kFloat64);
  std::array<double, 2> intensity{};
  ASSERT_EQ(read->attributes[1].values.size(), sizeof intensity);
  std::memcpy(intensity.data(), read->attributes[1].values.data(), sizeof intensity);
  EXPECT_THAT(intensity, ElementsAre(3, 0.5));
}

TEST(PcdFields, PackedTextOfTypeUnsignedMayBeTheBitsOfAFloat) {
  const std::string file =
      header("x y z rgb", "4 4 4 4", "F F F U", "1 1 1 1", 2, "ascii") + "0 0 0 0\n0 0 0 2.3418052e-38\n";
  EXPECT_THAT(decode(file).cloud.rgb, ElementsAre(0U, 0xFF0000U));
}

TEST(PcdFields, TextOfFloatsFarAwayIsExact) {
  const std::string file = header("x y z", "4 4 4", "F F F", "1 1 1", 3, "ascii") +
                           "389425.4999 5819321.2498 50\n389425.5 5819321.26 50\n389425.6 5819321.27 50\n";
  const LabeledCloud read = decode(file);
  EXPECT_NEAR(read.cloud.y[1] - read.cloud.y[0], 0.0102, 1e-6);
  EXPECT_NEAR(read.cloud.x[1] - read.cloud.x[0], 0.0001, 1e-6);
}

TEST(PcdFields, ColorsThatAreWordsAreLeftOutAndMentioned) {
  const std::string file = header("x y z r g b", "4 4 4 1 1 1", "F F F U U U", "1 1 1 1 1 1", 2, "ascii") +
                           "0 0 0 1 2 3\n0 0 1 0 dark blue\n";
  const LabeledCloud read = decode(file);
  EXPECT_FALSE(read.cloud.has_color());
  ASSERT_EQ(read.warnings.size(), 1U);
  EXPECT_EQ(read.warnings[0].reason, WarningReason::kColorNotUsed);
  EXPECT_THAT(read.warnings[0].message, testing::HasSubstr("'dark' is not a value of field 'g' (an integer of 1"));
}

TEST(PcdFields, KeywordsMayBeInSmallLetters) {
  const LabeledCloud read =
      decode("version 0.7\nfields X Y Z\nsize 4 4 4\ntype F F F\nwidth 1\nheight 1\npoints 1\ndata ASCII\n1 2 3\n");
  EXPECT_THAT(read.cloud.z, ElementsAre(3));
}

TEST(PcdFields, LabelsThatAreWordsAreLeftOutAndMentioned) {
  const std::string file = header("x y z label", "4 4 4 4", "F F F U", "1 1 1 1", 2, "ascii") + "0 0 0 1\n0 0 1 cup\n";
  const LabeledCloud read = decode(file);
  EXPECT_THAT(read.label, IsEmpty());
  ASSERT_EQ(read.warnings.size(), 1U);
  EXPECT_EQ(read.warnings[0].reason, WarningReason::kLabelNotUsed);
}

TEST(PcdFields, TextOfExtremeNumbers) {
  const std::string file = header("x y z", "4 8 4", "F F F", "1 1 1", 2, "ascii") + "nan -inf 1e-60\n-nan 1e300 +1e60";
  const Cloud cloud = decode(file).cloud;
  const float infinity = std::numeric_limits<float>::infinity();
  EXPECT_TRUE(std::isnan(cloud.x[0]) && std::isnan(cloud.x[1]));
  EXPECT_THAT(cloud.y, ElementsAre(-infinity, infinity));
  EXPECT_THAT(cloud.z, ElementsAre(0.0F, infinity));

  const std::string microsoft = header("x y z", "4 8 4", "F F F", "1 1 1", 1, "ascii") + "1.#QNAN -1.#IND000 -1.#INF";
  const Cloud odd = decode(microsoft).cloud;
  EXPECT_TRUE(std::isnan(odd.x[0]) && std::isnan(odd.y[0]));
  EXPECT_THAT(odd.z, ElementsAre(-infinity));
}

TEST(PcdFields, SignedBytesInTextMayBeBelowZero) {
  const std::string file =
      header("x y z r g b", "4 4 4 1 1 1", "F F F I I I", "1 1 1 1 1 1", 1, "ascii") + "1 2 3 -106 110 70";
  EXPECT_THAT(decode(file).cloud.rgb, ElementsAre(pack_rgb(150, 110, 70)));
}

struct ViewCase {
  std::uint32_t height;
  std::string viewpoint;
  View expected;
};

TEST(PcdView, FollowsFromShapeAndViewpoint) {
  const std::vector<ViewCase> cases{
      {2, "VIEWPOINT 0 0 0 1 0 0 0\n", View::camera()},
      {2, "", View::camera()},
      {2, "VIEWPOINT -0 0 0 -1 0 0 0\n", View::camera()},
      {2, "VIEWPOINT 1 2 3 1 0 0 0\n", View::world(1, 2, 3)},
      {2, "VIEWPOINT 0 0 0 0 1 0 0\n", View::camera()},
      {1, "VIEWPOINT 0 0 0 1 0 0 0\n", View::world()},
      {1, "VIEWPOINT 0.5 -1 1e3 1 0 0 0\n", View::world(0.5, -1, 1000)},
  };
  for (const ViewCase& c : cases) {
    const std::string size = "WIDTH " + std::to_string(4 / c.height) + "\nHEIGHT " + std::to_string(c.height) + "\n";
    const std::string file =
        "FIELDS x y z\nSIZE 4 4 4\nTYPE F F F\n" + size + c.viewpoint + "DATA ascii\n0 0 1\n0 0 1\n0 0 1\n0 0 1\n";
    const LabeledCloud read = decode(file);
    EXPECT_EQ(read.cloud.view, c.expected) << file << read.view_rule;
    EXPECT_THAT(read.view_rule, testing::StartsWith(c.expected.kind == ViewKind::kCamera ? "CAMERA" : "WORLD"));
    if (read.cloud.view.kind == ViewKind::kWorld) {
      EXPECT_THAT(read.view_rule, testing::HasSubstr("VIEWPOINT"));
    }

    const auto given = decode_pcd(bytes_of(file), DecodeLimits{}, {.view = View::world(7, 8, 9)});
    ASSERT_TRUE(given.ok());
    EXPECT_EQ(given->cloud.view, View::world(7, 8, 9));
    EXPECT_THAT(given->view_rule, testing::HasSubstr("asked for"));
  }
}

}  // namespace
}  // namespace segserve::codec
