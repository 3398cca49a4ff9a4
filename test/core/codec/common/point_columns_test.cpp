// SPDX-License-Identifier: Apache-2.0
#include "core/codec/common/point_columns.hpp"

#include <span>

#include "gmock/gmock.h"

namespace segserve::codec {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;

/// Reads points at the origin whose red channel has these values; the other two are 0.
template <typename T>
LabeledCloud with_red(const std::vector<T>& red, ScalarType type, ChannelKind kind = ChannelKind::kIntensity) {
  const std::vector<T> zeros(red.size());
  PointTable table{.fields = {{"x"}, {"r", type}, {"g", type}}, .roles = {}, .width = 0, .height = 1, .column = {}};
  table.width = static_cast<std::uint32_t>(red.size());
  table.roles.position = {0, 0, 0};
  table.roles.channels = {{1, 2, 2}};
  table.roles.channel_kind = kind;
  table.column = [&](std::size_t field) {
    const auto bytes = std::as_bytes(std::span(field == 1 ? red : zeros));
    return Column{bytes.data(), sizeof(T), type};
  };
  LabeledCloud out;
  EXPECT_TRUE(read_points(table, {}, {}, {}, out).ok());
  return out;
}

template <typename T>
std::vector<std::uint32_t> red_of(const std::vector<T>& values, ScalarType type,
                                  ChannelKind kind = ChannelKind::kIntensity) {
  std::vector<std::uint32_t> red;
  for (const std::uint32_t rgb : with_red(values, type, kind).cloud.rgb) red.push_back(rgb >> 16U);
  return red;
}

TEST(PointColumns, TheValuesTellWhatFullIntensityIs) {
  EXPECT_THAT(red_of<float>({0, 0.5, 1}, ScalarType::kFloat32), ElementsAre(0, 128, 255));
  EXPECT_THAT(red_of<double>({0, 100.4, 255}, ScalarType::kFloat64), ElementsAre(0, 100, 255));
  EXPECT_THAT(red_of<std::uint16_t>({0, 100, 255}, ScalarType::kUint16), ElementsAre(0, 100, 255));
  EXPECT_THAT(red_of<std::uint16_t>({0, 150 * 257, 65535}, ScalarType::kUint16), ElementsAre(0, 150, 255));
  EXPECT_THAT(red_of<std::uint16_t>({0, 150 * 256, 255 * 256}, ScalarType::kUint16), ElementsAre(0, 150, 255));
  EXPECT_THAT(red_of<std::int32_t>({-5, 1, 40}, ScalarType::kInt32), ElementsAre(0, 1, 40));
  EXPECT_THAT(red_of<float>({NAN, -1, 1}, ScalarType::kFloat32), ElementsAre(0, 0, 255));
}

TEST(PointColumns, OneFieldMayHaveAllChannels) {
  const std::vector<std::array<float, 3>> values{{1, 0.5, 0}, {0, 0, 1}};
  PointTable table{
      .fields = {{"x"}, {"rgb", ScalarType::kFloat32, 3}}, .roles = {}, .width = 2, .height = 1, .column = {}};
  table.roles.position = {0, 0, 0};
  table.roles.color_vector = 1;
  table.column = [&](std::size_t) {
    return Column{std::as_bytes(std::span(values)).data(), sizeof(values[0]), ScalarType::kFloat32};
  };
  LabeledCloud out;
  ASSERT_TRUE(read_points(table, {}, {}, {}, out).ok());
  EXPECT_THAT(out.cloud.rgb, ElementsAre(pack_rgb(255, 128, 0), pack_rgb(0, 0, 255)));
}

TEST(PointColumns, SignedBytesAreTheSameEightBits) {
  EXPECT_THAT(red_of<std::int8_t>({0, 127, -56, -1}, ScalarType::kInt8), ElementsAre(0, 127, 200, 255));
}

TEST(PointColumns, FloatsOnBothSidesOfZeroHaveItAsHalfIntensity) {
  EXPECT_THAT(red_of<float>({-1, 0, 0.5, 1}, ScalarType::kFloat32), ElementsAre(0, 128, 191, 255));
  EXPECT_THAT(red_of<float>({-0.01F, 0, 0.5, 1}, ScalarType::kFloat32), ElementsAre(0, 0, 128, 255)) << "a slip";
}

TEST(PointColumns, ColorsOfAnUnknownRangeAreMentioned) {
  const auto message_of = [](const LabeledCloud& read) {
    return read.warnings.size() == 1 && read.warnings[0].reason == WarningReason::kColorNotUsed
               ? read.warnings[0].message
               : "";
  };
  EXPECT_THAT(message_of(with_red<std::uint16_t>({0, 800, 700}, ScalarType::kUint16)),
              HasSubstr("2 of 9 color values are beyond 0 to 255"));
  EXPECT_THAT(message_of(with_red<double>({-128, 3, 127}, ScalarType::kFloat64)), HasSubstr("from -128 to 127"));
  EXPECT_THAT(message_of(with_red<float>({0, 0.3F, 1.7F}, ScalarType::kFloat32)), HasSubstr("reach only 1.7 of 255"));
  EXPECT_THAT(message_of(with_red<std::uint16_t>({0, 4095, 700}, ScalarType::kUint16)),
              HasSubstr("reach only 4095 of 65535, and are nearly black; values of 12 bits must be multiplied by 16"));
  EXPECT_EQ(with_red<double>({0, 5, 256}, ScalarType::kFloat64).warnings.size(), 0U);
  EXPECT_EQ(with_red<float>({NAN, -1, 1}, ScalarType::kFloat32).warnings.size(), 0U);
  EXPECT_EQ(with_red<float>({-3, 9}, ScalarType::kFloat32, ChannelKind::kSphericalHarmonic).warnings.size(), 0U);
}

TEST(PointColumns, SphericalHarmonicsOfSplatsAreColors) {
  const float most = 0.5F / 0.28209479F;
  EXPECT_THAT(red_of<float>({-most, 0, most, 9}, ScalarType::kFloat32, ChannelKind::kSphericalHarmonic),
              ElementsAre(0, 128, 255, 255));
}

TEST(PointColumns, LabelsThatAreNoneAreLeftOutAndMentioned) {
  PointTable table{.fields = {{"x"}, {"label"}}, .roles = {}, .width = 3, .height = 1, .column = {}};
  table.roles.position = {0, 0, 0};
  table.roles.label = 1;
  const std::vector<float> values{1, 2.5, 3};
  table.column = [&](std::size_t) {
    return Column{std::as_bytes(std::span(values)).data(), sizeof(float), ScalarType::kFloat32};
  };
  LabeledCloud out;
  ASSERT_TRUE(read_points(table, {}, {}, {}, out).ok());
  EXPECT_TRUE(out.label.empty());
  ASSERT_EQ(out.warnings.size(), 1U);
  EXPECT_EQ(out.warnings[0].reason, WarningReason::kLabelNotUsed);
}

TEST(PointColumns, AColumnOfPointsIsARow) {
  PointTable table{.fields = {{"x"}}, .roles = {}, .width = 1, .height = 3, .column = {}};
  table.roles.position = {0, 0, 0};
  const std::vector<float> values{1, 2.5, 3};
  table.column = [&](std::size_t) {
    return Column{std::as_bytes(std::span(values)).data(), sizeof(float), ScalarType::kFloat32};
  };
  LabeledCloud out;
  ASSERT_TRUE(read_points(table, {}, {}, {}, out).ok());
  EXPECT_EQ(out.cloud.width, 3U);
  EXPECT_EQ(out.cloud.height, 1U);
}

TEST(PointColumns, ATableWithoutPointsIsAskedForNoColumn) {
  PointTable table{.fields = {{"x"}}, .roles = {}, .width = 0, .height = 1, .column = {}};
  table.roles.position = {0, 0, 0};
  bool is_asked = false;
  table.column = [&is_asked](std::size_t) {
    is_asked = true;
    return Column();
  };
  LabeledCloud out;
  ASSERT_TRUE(read_points(table, {}, {.keep_everything = true}, {}, out).ok());
  EXPECT_FALSE(is_asked);
  EXPECT_EQ(out.cloud.size(), 0U);
}

}  // namespace
}  // namespace segserve::codec
