// SPDX-License-Identifier: Apache-2.0
#include "core/codec/obj/obj.hpp"

#include <array>
#include <cstring>

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
