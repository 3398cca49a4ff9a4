// SPDX-License-Identifier: Apache-2.0
// The columns of a table without names are taken for what their values tell.
#include <fmt/format.h>
#include <gmock/gmock.h>

#include <functional>
#include <string>

#include "test/core/codec/text/read_table.hpp"

namespace segserve::codec {
namespace {

using testing::HasSubstr;
using testing::IsEmpty;

/// 200 rows of x y z and what `rest` gives for each.
std::string rows(const std::function<std::string(int)>& rest) {
  std::string text;
  for (int i = 0; i < 200; ++i) {
    text += fmt::format("{}.5 {} {} {}\n", i % 20, i / 20, 0.01 * (i * 7919 % 100), rest(i));
  }
  return text;
}

TEST(UnnamedColumns, ThreeThatLookAlikeAreAColor) {
  for (const auto& color : std::vector<std::function<std::string(int)>>{
           [](int i) { return fmt::format("{} {} {}", i * 7 % 256, i * 13 % 256, i * 29 % 200); },
           [](int i) { return fmt::format("{} {} {}", 257 * (i * 7 % 256), 257 * (i * 13 % 256), 40000); },
           [](int i) { return fmt::format("{} {} {}", 0.01 * (i * 7 % 100), 0.01 * (i * 13 % 100), i % 2); },
           [](int i) { return fmt::format("{} 0 0", i * 7 % 256); }}) {
    const LabeledCloud cloud = read_table(rows(color));
    EXPECT_TRUE(cloud.cloud.has_color()) << color(1);
    EXPECT_THAT(cloud.warnings, IsEmpty()) << color(1);
  }
}

TEST(UnnamedColumns, ThreeThatDifferAreNone) {
  for (const auto& values : std::vector<std::function<std::string(int)>>{
           [](int i) { return fmt::format("{} {} {}", i * 7 % 256, i % 16, 5e-6 * i); },      // intensity ring time
           [](int i) { return fmt::format("{} {} {}", i * 7919 % 4096, i % 3 + 1, i % 6); },  // intensity return class
           [](int i) { return fmt::format("{} {} {}", i % 3 + 1, i % 2, i % 6); },            // return flag class
           [](int i) { return fmt::format("{} {} {}", 3.25, 0.01 * (i * 7919 % 628), i); }}) {  // range azimuth time
    const LabeledCloud cloud = read_table(rows(values));
    EXPECT_FALSE(cloud.cloud.has_color()) << values(1);
    EXPECT_EQ(cloud.attributes.size(), 3U) << values(1);
    ASSERT_EQ(cloud.warnings.size(), 1U) << values(1);
    EXPECT_THAT(cloud.warnings[0].message, HasSubstr("are taken as: x y z column_4 column_5 column_6")) << values(1);
  }
}

TEST(UnnamedColumns, AnIntensityMayStandOnEitherSideOfAColor) {
  const auto color = [](int i) { return fmt::format("{} {} {}", i * 7 % 256, i * 13 % 256, i * 29 % 200); };
  const LabeledCloud behind = read_table(rows([&](int i) { return fmt::format("{} {}", color(i), 0.003 * i); }));
  const LabeledCloud before =
      read_table(rows([&](int i) { return fmt::format("{} {}", 0.003 * (199 - i), color(i)); }));
  EXPECT_EQ(behind.cloud.rgb, before.cloud.rgb);
  EXPECT_THAT(behind.warnings.at(0).message, HasSubstr("x y z red green blue column_7"));
  // Lists of LAS points have returns and flags between intensity and color.
  const LabeledCloud las =
      read_table(rows([&](int i) { return fmt::format("{} 1 1 2 {} {}", i * 7919 % 4096, i % 2, color(i)); }));
  EXPECT_EQ(las.cloud.rgb, before.cloud.rgb) << las.warnings.at(0).message;
}

TEST(UnnamedColumns, AColorOfBytesComesBeforeOneOfLargerNumbers) {
  const auto color = [](int i) { return fmt::format("{} {} {}", i * 7 % 256, i * 13 % 256, i * 29 % 200); };
  const std::vector<std::uint32_t> rgb = read_table(rows(color)).cloud.rgb;
  for (const int most : {300, 2000}) {  // instances, or an intensity of 12 bits
    const auto other = [most](int i) { return i * 7919 % most; };
    const LabeledCloud behind = read_table(rows([&](int i) { return fmt::format("{} {}", color(i), other(i)); }));
    EXPECT_EQ(behind.cloud.rgb, rgb) << most;
    const LabeledCloud before = read_table(rows([&](int i) { return fmt::format("{} {}", other(i), color(i)); }));
    EXPECT_EQ(before.cloud.rgb, rgb) << most;
    const LabeledCloud both =
        read_table(rows([&](int i) { return fmt::format("{} {} {}", other(i), color(i), 0.37 * (i * 31 % 97)); }));
    EXPECT_EQ(both.cloud.rgb, rgb) << most;
  }
}

TEST(UnnamedColumns, ADecimalBesideAConstantColorIsNoneOfItsChannels) {
  for (const std::string_view color : {"0 0 0", "255 255 255", "10 20 30"}) {
    for (const double scale : {2.55, 0.01}) {
      const LabeledCloud cloud =
          read_table(rows([&](int i) { return fmt::format("{} {}", color, scale * (i * 7919 % 100)); }));
      const bool is_black = color == "0 0 0";  // which is as good as none
      EXPECT_EQ(cloud.cloud.has_color(), !is_black) << color << " " << scale;
      ASSERT_EQ(cloud.attributes.size(), is_black ? 4U : 1U) << color << " " << scale;
      EXPECT_EQ(cloud.attributes.back().name, "column_7") << color << " " << scale;
    }
  }
}

TEST(UnnamedColumns, ARowAndAColumnOfAGridMayComeFirst) {
  const auto exported = [](const std::string& rest, bool has_gaps) {
    std::string text;
    for (int row = 3; row < 15; ++row) {
      for (int column = 0; column < 20; ++column) {
        if (has_gaps && (row * 20 + column) % 7 == 0) continue;
        text += fmt::format("{} {} {:.3f} {:.3f} {:.3f}{}\n", row, column, 0.11 * column, 0.13 * row, 2.001, rest);
      }
    }
    return text;
  };
  for (const std::string rest : {"", " 9 8 7", " 0.5"}) {
    for (const bool has_gaps : {false, true}) {
      const LabeledCloud cloud = read_table(exported(rest, has_gaps));
      EXPECT_THAT(cloud.warnings.at(0).message, HasSubstr("are taken as: row column x y z")) << rest;
      EXPECT_EQ(cloud.cloud.z[0], 2.001F);
      EXPECT_EQ(cloud.cloud.has_color(), rest.size() > 4);
    }
  }
  std::string heights;  // a map with a height and a normal at each whole x and y
  for (int i = 0; i < 200; ++i) heights += fmt::format("{} {} {} 0.6 0 0.8\n", i / 20, i % 20, 0.25 * (i % 3));
  EXPECT_EQ(read_table(heights).cloud.x[25], 1);
}

TEST(UnnamedColumns, ColorsMayBeMissing) {
  for (const char* missing : {"nan nan nan", "-1 -1 -1"}) {
    const LabeledCloud cloud =
        read_table(rows([&](int i) { return i % 10 == 0 ? missing : fmt::format("{} {} 90", i % 200, i * 7 % 256); }));
    ASSERT_TRUE(cloud.cloud.has_color()) << missing;
    ASSERT_EQ(cloud.warnings.size(), 1U) << missing;
    EXPECT_EQ(cloud.warnings[0].reason, WarningReason::kColorNotUsed);
    EXPECT_THAT(cloud.warnings[0].message, HasSubstr("20 of 200 colors are ")) << missing;
    EXPECT_THAT(cloud.warnings[0].message, HasSubstr(", and become black")) << missing;
  }
}

TEST(UnnamedColumns, AFirstColumnThatRisesMayBeATime) {
  std::string text;
  for (int i = 0; i < 200; ++i) text += fmt::format("{} {} {} {}\n", 0.001 * i, i % 20, i / 20, 0.01 * (i % 7));
  const LabeledCloud cloud = read_table(text);
  ASSERT_EQ(cloud.warnings.size(), 1U);
  EXPECT_THAT(cloud.warnings[0].message, HasSubstr("are taken as: x y z intensity;"));
}

}  // namespace
}  // namespace segserve::codec
