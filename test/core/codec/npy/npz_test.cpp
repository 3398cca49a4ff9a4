// SPDX-License-Identifier: Apache-2.0
#include <zlib.h>

#include "core/codec/npy/npy.hpp"
#include "segserve/codec/cloud_file.hpp"
#include "test/core/codec/support/damaged_bytes.hpp"
#include "test/core/codec/support/deflate_bytes.hpp"
#include "test/core/codec/support/las_file.hpp"
#include "test/core/codec/support/npy_file.hpp"
#include "test/core/codec/support/sample_cloud.hpp"

namespace segserve::codec {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;

std::string deflated(const std::string& bytes) { return deflate_bytes(bytes, -MAX_WBITS); }

using Members = std::vector<std::pair<std::string, std::string>>;

/// A zip archive, whose members are stored or deflated.
std::string zip(const Members& members, bool deflate_them) {
  std::string archive, directory;
  for (const auto& [name, content] : members) {
    const std::string packed = deflate_them ? deflated(content) : content;
    std::string local(30, '\0'), entry(46, '\0');
    put<std::uint32_t>(local, 0, 0x04034b50);
    put(local, 26, static_cast<std::uint16_t>(name.size()));
    put<std::uint32_t>(entry, 0, 0x02014b50);
    put<std::uint16_t>(entry, 10, deflate_them ? 8 : 0);
    put(entry, 20, static_cast<std::uint32_t>(packed.size()));
    put(entry, 24, static_cast<std::uint32_t>(content.size()));
    put(entry, 28, static_cast<std::uint16_t>(name.size()));
    put(entry, 42, static_cast<std::uint32_t>(archive.size()));
    archive += local + name + packed;
    directory += entry + name;
  }
  std::string end(22, '\0');
  put<std::uint32_t>(end, 0, 0x06054b50);
  put(end, 10, static_cast<std::uint16_t>(members.size()));
  put(end, 12, static_cast<std::uint32_t>(directory.size()));
  put(end, 16, static_cast<std::uint32_t>(archive.size()));
  return archive + directory + end;
}

Members sample_members() {
  return {{"points.npy", npy_file("'<f8'", "(2, 3)", raw<double>({1, 2, 3, 4, 5, 6}))},
          {"colors.npy", npy_file("'|u1'", "(2, 3)", raw<std::uint8_t>({255, 128, 0, 1, 2, 3}))},
          {"labels.npy", npy_file("'<i8'", "(2,)", raw<std::int64_t>({7, 9}))},
          {"intensity.npy", npy_file("'<f4'", "(2,)", raw<float>({0.5, 0.25}))}};
}

LabeledCloud read_archive(const std::string& file) {
  auto cloud = decode_cloud(bytes_of(file), {}, {.keep_everything = true});
  EXPECT_TRUE(cloud.ok()) << cloud.status();
  return cloud.ok() ? *std::move(cloud) : LabeledCloud{};
}

TEST(Npz, PointsHaveManyNames) {
  std::vector<float> values;
  for (int i = 0; i < 60; ++i) values.push_back(static_cast<float>(i));
  const std::string points = npy_file("'<f4'", "(20, 3)", raw(values));
  const std::string colors = npy_file("'|u1'", "(20, 3)", std::string(60, '\7'));
  struct Case {
    const char *points, *colors;
    std::size_t warnings;
  };
  for (const Case& c : std::vector<Case>{{"pc", "rgb", 0},
                                         {"point_cloud", "colors", 0},
                                         {"verts", "colors", 0},
                                         {"arr_0", "arr_1", 0},
                                         {"lidar", "rgb", 1},
                                         {"xyz_world", "rgb", 1}}) {
    const LabeledCloud cloud =
        read_archive(zip({{std::string(c.points) + ".npy", points}, {std::string(c.colors) + ".npy", colors}}, false));
    ASSERT_EQ(cloud.cloud.size(), 20U) << c.points;
    EXPECT_EQ(cloud.cloud.z[19], 59) << c.points;
    EXPECT_EQ(cloud.cloud.has_color() ? cloud.cloud.rgb[0] : 0, 0x070707U) << c.points;
    EXPECT_EQ(cloud.warnings.size(), c.warnings) << c.points;
  }
  const auto ambiguous = decode_cloud(bytes_of(zip({{"a.npy", points}, {"b.npy", points}}, false)), {});
  EXPECT_THAT(std::string(ambiguous.status().message()), HasSubstr("there must be an array 'points'"));
}

TEST(Npz, ArchivesOfOtherProgramsAreNamed) {
  for (const auto& [member, name] : std::vector<std::pair<std::string, std::string>>{
           {"archive/data.pkl", "PyTorch"}, {"xl/workbook.xml", "Excel"}, {"a.usdc", "USDZ"}, {"doc.kml", "KMZ"}}) {
    const auto read = decode_cloud(bytes_of(zip({{member, "x"}}, false)), {});
    EXPECT_THAT(std::string(read.status().message()), HasSubstr(name));
  }
}

TEST(Npz, ArraysAreFoundByTheirNames) {
  for (const bool deflate_them : {false, true}) {
    const LabeledCloud cloud = read_archive(zip(sample_members(), deflate_them));
    EXPECT_THAT(cloud.cloud.z, ElementsAre(3, 6));
    EXPECT_THAT(cloud.cloud.rgb, ElementsAre(pack_rgb(255, 128, 0), pack_rgb(1, 2, 3)));
    EXPECT_THAT(cloud.label, ElementsAre(7, 9));
    ASSERT_EQ(cloud.attributes.size(), 2U);
    EXPECT_EQ(cloud.attributes[1].name, "intensity");
    EXPECT_TRUE(cloud.warnings.empty());
  }
}

TEST(Npz, AxesOfTheirOwnAndASingleArrayAreRead) {
  const auto axis = [](float first) { return npy_file("'<f4'", "(1, 2)", raw<float>({first, first + 1})); };
  const LabeledCloud axes = read_archive(zip({{"x.npy", axis(1)}, {"y.npy", axis(3)}, {"z.npy", axis(5)}}, true));
  EXPECT_THAT(axes.cloud.y, ElementsAre(3, 4));
  EXPECT_EQ(axes.cloud.width, 2U);
  EXPECT_THAT(read_archive(zip({{"arr_0.npy", sample_members()[0].second}}, true)).cloud.x, ElementsAre(1, 4));
}

TEST(Npz, WhatIsNotUsedIsMentioned) {
  Members members = sample_members();
  members.emplace_back("pose.npy", npy_file("'<f8'", "(4, 4)", std::string(128, '\0')));
  members.emplace_back("notes.txt", "hello");
  const LabeledCloud cloud = read_archive(zip(members, true));
  ASSERT_EQ(cloud.warnings.size(), 2U);
  EXPECT_THAT(cloud.warnings[0].message, HasSubstr("'notes.txt' in the archive is no array"));
  EXPECT_THAT(cloud.warnings[1].message, HasSubstr("'pose' of shape (4, 4) is not kept"));
}

TEST(Npz, MembersThatCannotBeOpenedAreMentionedUnlessTheyHaveThePositions) {
  const std::string pickled = npy_file("'|O'", "()", "pickle");
  Members members = sample_members();
  members.emplace_back("meta.npy", pickled);
  const LabeledCloud cloud = read_archive(zip(members, true));
  EXPECT_THAT(cloud.cloud.z, ElementsAre(3, 6));
  ASSERT_EQ(cloud.warnings.size(), 1U);
  EXPECT_EQ(cloud.warnings[0].reason, WarningReason::kAttributeNotKept);
  EXPECT_THAT(cloud.warnings[0].message, HasSubstr("'meta' in the archive is not kept"));
  EXPECT_THAT(cloud.warnings[0].message, HasSubstr("Python objects"));
  EXPECT_EQ(read_archive(zip({sample_members()[0], {"meta.npy", pickled}}, true)).warnings.size(), 1U);
  EXPECT_EQ(read_archive(zip({{"a.npy", sample_members()[0].second}, {"meta.npy", pickled}}, true)).cloud.size(), 2U);
  members = sample_members();
  members[0].second = pickled;
  expect_fault(decode_cloud(bytes_of(zip(members, true)), {}).status(), "Python objects");
  expect_fault(decode_cloud(bytes_of(zip({members[0], members[1]}, true)), {}).status(), "Python objects");
}

TEST(Npz, NamesCountInAnyCase) {
  Members members = sample_members();
  members[0].first = "Position.npy";
  members[1].first = "vertex_Colors.npy";
  members[2].first = "Labels.npy";
  const LabeledCloud cloud = read_archive(zip(members, true));
  EXPECT_THAT(cloud.cloud.z, ElementsAre(3, 6));
  EXPECT_THAT(cloud.cloud.rgb, ElementsAre(pack_rgb(255, 128, 0), pack_rgb(1, 2, 3)));
  EXPECT_THAT(cloud.label, ElementsAre(7, 9));
}

TEST(Npz, OtherPositionsAndColorsAreAttributes) {
  Members members = sample_members();
  members.emplace_back("pos.npy", members[0].second);
  members.emplace_back("rgb.npy", members[1].second);
  const LabeledCloud cloud = read_archive(zip(members, true));
  EXPECT_THAT(cloud.cloud.z, ElementsAre(3, 6));
  EXPECT_TRUE(cloud.cloud.has_color());
  EXPECT_EQ(cloud.attributes.size(), 4U);
}

TEST(Npz, EachFaultIsNamed) {
  expect_fault(decode_cloud(bytes_of(zip({{"scene.ply", "ply"}}, true)), {}).status(),
               "this is a zip archive without an array of NumPy (.npy) in it; unpack it first; it has 'scene.ply'");
  expect_fault(decode_cloud(bytes_of(zip({}, true)), {}).status(), "it has no files");
  const std::string array = sample_members()[0].second;
  expect_fault(decode_cloud(bytes_of(zip({{"a.npy", array}, {"b.npy", array}}, true)), {}).status(), "it has 'a', 'b'");
  std::string encrypted = zip({{"a.npy", array}}, false);
  put<std::uint16_t>(encrypted, encrypted.size() - 22 - 51 + 8, 1);
  expect_fault(decode_cloud(bytes_of(encrypted), {}).status(), "'a.npy' is encrypted");
  std::string strange = zip({{"a.npy", array}}, false);
  put<std::uint16_t>(strange, strange.size() - 22 - 51 + 10, 12);
  expect_fault(decode_cloud(bytes_of(strange), {}).status(), "compressed by method 12");
  std::string large = zip({{"a.npy", array}}, true);
  put<std::uint32_t>(large, large.size() - 22 - 51 + 24, 4'000'000'000);
  expect_fault(decode_cloud(bytes_of(large), {}).status(), "cannot hold the claimed 4000000000 bytes");
  expect_over_limit(decode_cloud(bytes_of(large), {.max_bytes = 1000}).status(), "max_bytes",
                    "decompressed 4000000000");
  expect_fault(decode_cloud(bytes_of("PK\3\4 and no more"), {}).status(), "its list of members is missing");
}

TEST(Npz, DamageDoesNoHarm) {
  const auto decode = [](const std::string& bytes) -> absl::StatusOr<Cloud> {
    auto cloud = decode_cloud(bytes_of(bytes), kDamageLimits, {.keep_everything = true});
    if (!cloud.ok()) return cloud.status();
    return cloud->cloud;
  };
  for (const bool deflate_them : {false, true}) {
    expect_truncations_refused(zip(sample_members(), deflate_them), decode);
    expect_flips_survived(zip(sample_members(), deflate_them), decode);
  }
}

}  // namespace
}  // namespace segserve::codec
