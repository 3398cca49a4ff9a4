// SPDX-License-Identifier: Apache-2.0
#include "core/codec/obj/obj.hpp"

#include <array>
#include <atomic>
#include <cstring>
#include <tuple>
#include <utility>

#include "segserve/codec/cloud_file.hpp"
#include "test/core/codec/support/damaged_bytes.hpp"
#include "test/core/codec/support/sample_cloud.hpp"

namespace segserve::codec {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;

constexpr std::string_view kCube =
    "# a mesh\nmtllib cube.mtl\no cube\nv 1 2 3 1.0 0.5 0\nv 4 5 6 0 0 1\nvt 0 0\nvn 0 0 1\nusemtl red\ns off\n"
    "f 1/1/1 \\\n2/1/1 1/1/1\nl 1 2\n";

TEST(Obj, VerticesAndTheirColorsAreRead) {
  const auto cloud = decode_cloud(bytes_of(kCube), {});
  ASSERT_TRUE(cloud.ok()) << cloud.status();
  EXPECT_THAT(cloud->cloud.x, ElementsAre(1, 4));
  EXPECT_THAT(cloud->cloud.z, ElementsAre(3, 6));
  EXPECT_THAT(cloud->cloud.rgb, ElementsAre(pack_rgb(255, 128, 0), pack_rgb(0, 0, 255)));
  EXPECT_TRUE(cloud->warnings.empty());
}

TEST(Obj, FacesAreMentionedIfEverythingIsToBeKept) {
  const auto cloud = decode_obj(bytes_of("v 1 2 3\nv 4 5 6\nv 7 8 8\nf 1 2 3\nl 1 2\n"), {}, {.keep_everything = true});
  ASSERT_TRUE(cloud.ok()) << cloud.status();
  ASSERT_EQ(cloud->warnings.size(), 1U);
  EXPECT_EQ(cloud->warnings[0].reason, WarningReason::kAttributeNotKept);
  EXPECT_THAT(cloud->warnings[0].message, HasSubstr("faces and lines between the vertices are not kept; there are 2"));
}

TEST(Obj, NormalsAreKeptIfEachVertexHasOne) {
  const auto kept = [](std::string_view file) { return decode_obj(bytes_of(file), {}, {.keep_everything = true}); };
  const auto cloud = kept("v 1 2 3\nvn 0 0 1\nv 4 5 6\nvn 0 1 0\n");
  ASSERT_TRUE(cloud.ok()) << cloud.status();
  ASSERT_EQ(cloud->attributes.size(), 3U);
  EXPECT_EQ(cloud->attributes[1].name, "ny");
  std::array<double, 2> ny{};
  ASSERT_EQ(cloud->attributes[1].values.size(), sizeof ny);
  std::memcpy(ny.data(), cloud->attributes[1].values.data(), sizeof ny);
  EXPECT_THAT(ny, ElementsAre(0, 1));

  const auto mesh = kept("v 1 2 3\nv 4 5 6\nvn 0 1 0\n");
  ASSERT_TRUE(mesh.ok()) << mesh.status();
  EXPECT_TRUE(mesh->attributes.empty());
  ASSERT_EQ(mesh->warnings.size(), 1U);
  EXPECT_EQ(mesh->warnings[0].reason, WarningReason::kAttributeNotKept);
  EXPECT_THAT(mesh->warnings[0].message, HasSubstr("2 vertices have 1 of them"));
}

TEST(Obj, ColorsInMaterialsAreMentioned) {
  const auto cloud = decode_cloud(bytes_of("mtllib a.mtl\nusemtl skin\nv 1 2 3\nv 4 5 6\nvt 0 0\n"), {});
  ASSERT_TRUE(cloud.ok()) << cloud.status();
  ASSERT_EQ(cloud->warnings.size(), 1U);
  EXPECT_EQ(cloud->warnings[0].reason, WarningReason::kColorNotUsed);
}

TEST(Obj, AnAlphaBehindTheColorIsLeftOut) {
  const auto cloud = decode_cloud(bytes_of("v 1 2 3 1.0 0.5 0 1\nv 4 5 6 0 0 1 0.5\n"), {});
  ASSERT_TRUE(cloud.ok()) << cloud.status();
  EXPECT_THAT(cloud->cloud.z, ElementsAre(3, 6));
  EXPECT_THAT(cloud->cloud.rgb, ElementsAre(pack_rgb(255, 128, 0), pack_rgb(0, 0, 255)));
  EXPECT_TRUE(cloud->warnings.empty());
}

TEST(Obj, AWeightInFrontOfTheColorIsNoColor) {
  const auto colors = [](std::string_view file) { return decode_cloud(bytes_of(file), {})->cloud.rgb; };
  EXPECT_THAT(colors("v 1 2 3 1 0.5 0 1\nv 4 5 6 1.0 0 1 0.2\n"), ElementsAre(0x8000FFU, 0x00FF33U));
  EXPECT_THAT(colors("v 1 2 3 1 0.5 0 1\nv 4 5 6 0.9 0 1 0.2\n"), ElementsAre(0xFF8000U, 0xE600FFU)) << "no weight";
  EXPECT_THAT(colors("v 1 2 3 1 0.5 0 1\nv 4 5 6 1 0 1 1\n"), ElementsAre(0xFF8000U, 0xFF00FFU)) << "an alpha";
  EXPECT_THAT(colors("v 1 2 3 1 0.5 0 1\nv 4 5 6 1 0 1\n"), ElementsAre(0xFF8000U, 0xFF00FFU));
}

TEST(Obj, TheUnitInACommentIsTaken) {
  const std::vector<std::tuple<std::string, double, std::string>> cases{
      {"# File units = inches", 0.0254, "the coordinates are taken as in, as the file says"},
      {"# File units = millimeters", 0.001, "are taken as mm, as the file says"},
      {"# File units = feet", 0.3048, "are taken as ft"},
      {"#Units: cm ", 0.01, "are taken as cm"},
      {"# File units = meters", 1, ""},
      {"# File units = yards", 1, "are taken as m, because the unit 'yards' is not known"},
      {"# units are great", 1, ""},
      {"# Scale: 1", 1, ""}};
  for (const auto& [comment, meters, said] : cases) {
    const std::string file = comment + "\r\nv 1 2 3\r\nv 4 5 6\r\n";
    const auto cloud = decode_cloud(bytes_of(file), {});
    ASSERT_TRUE(cloud.ok()) << cloud.status();
    EXPECT_DOUBLE_EQ(cloud->placement.meters_per_unit(), meters) << comment;
    ASSERT_EQ(cloud->warnings.size(), said.empty() ? 0U : 1U) << comment;
    if (said.empty()) continue;
    EXPECT_EQ(cloud->warnings[0].reason, WarningReason::kUnitGuessed);
    EXPECT_THAT(cloud->warnings[0].message, HasSubstr(said));
    const auto given = decode_cloud(bytes_of(file), {}, {.unit = LengthUnit::kMeter});
    EXPECT_EQ(given->placement.meters_per_unit(), 1);
    EXPECT_TRUE(given->warnings.empty());
  }
}

TEST(Obj, PaintOfZBrushIsTheColor) {
  const std::string vertices = "v 1 2 3\nv 4 5 6\nv 7 8 9\n";
  for (const std::string_view paint :
       {"#MRGB ff966e46ff2a00ffff010100\n", "#MRGB ff966e46\r\n#MRGB 002A00FFff010100"}) {
    const auto cloud = decode_cloud(bytes_of(vertices + std::string(paint)), {});
    ASSERT_TRUE(cloud.ok()) << cloud.status();
    EXPECT_THAT(cloud->cloud.rgb, ElementsAre(0x966E46U, 0x2A00FFU, 0x010100U)) << paint;
    EXPECT_TRUE(cloud->warnings.empty());
  }
  const std::vector<std::pair<std::string, std::string>> damaged{
      {"#MRGB ff966e46ff2a00ff\n", "because they do not fit"},
      {"#MRGB ff966e46ff2a00ffff0101001\n", "because some of them are no colors"},
      {"#MRGB ff966e46ff2a00ffff01010x\n", "because some of them are no colors"}};
  for (const auto& [paint, why] : damaged) {
    const auto cloud = decode_cloud(bytes_of(vertices + paint), {});
    ASSERT_TRUE(cloud.ok()) << cloud.status();
    EXPECT_FALSE(cloud->cloud.has_color());
    ASSERT_EQ(cloud->warnings.size(), 1U) << paint;
    EXPECT_EQ(cloud->warnings[0].reason, WarningReason::kColorNotUsed);
    EXPECT_THAT(cloud->warnings[0].message, HasSubstr(why));
  }
  std::string long_paint = "v 1 2 3\n#MRGB ";
  for (int i = 0; i < 1000; ++i) long_paint += "ff000000";
  expect_over_limit(decode_cloud(bytes_of(long_paint), {.max_points = 999}).status(), "max_points", "1000 points");
  const std::atomic<bool> cancelled = true;
  WorkMeter meter;
  const StopToken stop(&cancelled, std::nullopt, &meter);
  for (int i = 0; i < 100'000; ++i) long_paint += "ff000000";
  EXPECT_EQ(decode_obj(bytes_of(long_paint), {}, {}, stop).status().code(), absl::StatusCode::kCancelled);
  EXPECT_LE(meter.units(), StopToken::kMostWorkAfterStop);
}

TEST(Obj, WhatIsNotUsedIsMentioned) {
  const auto cloud = decode_cloud(bytes_of("v 1 2 3 1 1 1\nv 4 5 6\nv 4 5 6 1\nwhatever 5\n"), {});
  ASSERT_TRUE(cloud.ok()) << cloud.status();
  EXPECT_EQ(cloud->cloud.size(), 3U);
  EXPECT_FALSE(cloud->cloud.has_color());
  ASSERT_EQ(cloud->warnings.size(), 2U);
  EXPECT_THAT(cloud->warnings[0].message, HasSubstr("1 lines are of no kind that OBJ has, and not used; the first is "
                                                    "line 4: 'whatever 5'"));
  EXPECT_THAT(cloud->warnings[1].message, HasSubstr("only 1 of 3 vertices"));
}

TEST(Obj, EachFaultNamesItsLine) {
  expect_fault(decode_cloud(bytes_of("v 1 2 3\nv 1 2\n"), {}).status(),
               "line 2: a vertex has 3, 4, 6 or 7 numbers, not 2");
  expect_fault(decode_cloud(bytes_of("v 1 2 3\nv 1 b 3\n"), {}).status(), "line 2: 'b' is not a number of a vertex");
  expect_fault(decode_cloud(bytes_of("v 1 2 3 4 5 6 7 8\n"), {}).status(), "line 1: a vertex has at most 7 numbers");
  expect_over_limit(decode_cloud(bytes_of(kCube), {.max_points = 1}).status(), "max_points", "2 points exceed");
}

TEST(Obj, DamageDoesNoHarm) {
  expect_flips_survived(std::string(kCube), [](const std::string& bytes) -> absl::StatusOr<Cloud> {
    auto cloud = decode_cloud(bytes_of(bytes), kDamageLimits);
    if (!cloud.ok()) return cloud.status();
    return cloud->cloud;
  });
}

}  // namespace
}  // namespace segserve::codec
