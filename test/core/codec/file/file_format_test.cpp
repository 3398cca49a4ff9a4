// SPDX-License-Identifier: Apache-2.0
// Every format out and in again: the same labels, the same sensor, the same points and other values.
#include "segserve/codec/file_format.hpp"

#include <fmt/format.h>

#include <array>
#include <cstring>
#include <limits>
#include <tuple>

#include "segserve/codec/cloud_file.hpp"
#include "test/core/codec/support/sample_cloud.hpp"

namespace segserve::codec {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;

constexpr std::array<FileFormat, 6> kClouds{FileFormat::kPcd, FileFormat::kPly, FileFormat::kLas,
                                            FileFormat::kXyz, FileFormat::kCsv, FileFormat::kNpy};

LabeledCloud read(const std::string& file) {
  auto cloud = decode_cloud(bytes_of(file), {}, {.keep_everything = true});
  EXPECT_TRUE(cloud.ok()) << cloud.status();
  return cloud.ok() ? *std::move(cloud) : LabeledCloud{};
}

std::string write(const FileContent& content, FileFormat format) {
  auto file = encode_file(content, format);
  EXPECT_TRUE(file.ok()) << file.status();
  return file.ok() ? file->bytes : "";
}

template <typename T>
Attribute attribute(std::string name, ScalarType type, const std::vector<T>& values, std::size_t count = 1) {
  const auto bytes = std::as_bytes(std::span(values));
  return {std::move(name), type, count, {bytes.begin(), bytes.end()}};
}

const Attribute* find(const LabeledCloud& cloud, std::string_view name) {
  for (const Attribute& attribute : cloud.attributes) {
    if (attribute.name == name) return &attribute;
  }
  return nullptr;
}

/// Points in front of a camera, whose coordinates have all 24 bits of floats.
Cloud camera_cloud(std::uint32_t width, std::uint32_t height) {
  std::mt19937 random(7);
  Cloud cloud;
  cloud.resize(std::size_t{width} * height, true);
  cloud.width = width;
  cloud.height = height;
  const auto between = [&](float low, float high) {
    return low + (high - low) * static_cast<float>(random()) / 4294967296.0F;
  };
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    cloud.x[i] = between(-1, 1);
    cloud.y[i] = between(-1, 1);
    cloud.z[i] = between(0.5, 2);
    cloud.rgb[i] = random() & 0xFFFFFFU;
  }
  return cloud;
}

TEST(FileFormat, LabelsColorsAndTheSensorSurvive) {
  Cloud cloud = camera_cloud(40, 1);
  std::vector<std::uint32_t> labels(cloud.size());
  for (std::uint32_t i = 0; i < labels.size(); ++i) labels[i] = i % 7 == 0 ? 4'000'000'000U + i : i % 5;
  for (const FileFormat format : kClouds) {
    for (const View& view : {View::camera(), View::world(), View::world(0, 0, 0), View::world(1, 2.5, -3)}) {
      SCOPED_TRACE(static_cast<int>(format));
      cloud.view = view;
      const LabeledCloud again = read(write({.cloud = cloud, .label = labels}, format));
      EXPECT_EQ(again.label, labels);
      EXPECT_EQ(again.cloud.view, view);
      EXPECT_EQ(again.cloud.rgb, cloud.rgb);
      ASSERT_EQ(again.cloud.size(), cloud.size());
      for (std::size_t i = 0; i < cloud.size(); ++i) {
        EXPECT_NEAR(again.cloud.x[i], cloud.x[i], 1e-9);
        EXPECT_NEAR(again.cloud.y[i], cloud.y[i], 1e-9);
        EXPECT_EQ(again.cloud.z[i], cloud.z[i]);
      }
    }
  }
}

TEST(FileFormat, DarkColorsSurvive) {
  Cloud cloud = camera_cloud(3, 1);
  cloud.rgb = {0, pack_rgb(1, 2, 3), pack_rgb(3, 0, 1)};
  for (const FileFormat format : {FileFormat::kLas, FileFormat::kNpy}) {
    EXPECT_EQ(read(write({.cloud = cloud}, format)).cloud.rgb, cloud.rgb);
  }
}

TEST(FileFormat, FarPositionsAndOtherValuesSurvive) {
  const FilePosition position{std::vector<double>{389425.125, 389426.375}, {5819321.5, 5819321.25}, {112, 112.5}};
  Cloud cloud;
  cloud.resize(2, false);
  cloud.width = 2;
  cloud.height = 1;
  cloud.view = View::world(389425, 5819321, 120);
  const std::vector<std::uint32_t> labels{2, 1};
  const std::vector<Attribute> attributes{
      attribute<std::uint16_t>("intensity", ScalarType::kUint16, {7, 65535}),
      attribute<double>("gps_time", ScalarType::kFloat64, {1.7e9 + 0.25, 1.7e9 + 0.5}),
      attribute<std::uint8_t>("return_number", ScalarType::kUint8, {3, 15}),
      attribute<std::uint8_t>("classification", ScalarType::kUint8, {2, 255}),
      attribute<float>("curvature", ScalarType::kFloat32, {0.5, -0.25}),
      attribute<std::int64_t>("stamp", ScalarType::kInt64, {1'700'000'000'123'456'789, -1}),
      attribute<std::uint32_t>("input_label", ScalarType::kUint32, {9, 8})};
  const FileContent content{.cloud = cloud, .label = labels, .attributes = attributes, .position = &position};
  for (const FileFormat format : {FileFormat::kPcd, FileFormat::kLas, FileFormat::kNpy}) {
    SCOPED_TRACE(static_cast<int>(format));
    const LabeledCloud again = read(write(content, format));
    EXPECT_EQ(again.label, labels);
    for (std::size_t axis = 0; axis < 3; ++axis) {
      for (std::size_t i = 0; i < 2; ++i) EXPECT_NEAR(again.file_position[axis][i], position[axis][i], 1e-9);
    }
    for (const Attribute& expected : attributes) {
      const Attribute* const found = find(again, expected.name);
      ASSERT_NE(found, nullptr) << expected.name;
      EXPECT_EQ(found->type, expected.type) << expected.name;
      EXPECT_EQ(found->values, expected.values) << expected.name;
    }
  }
  const LabeledCloud csv = read(write(content, FileFormat::kCsv));
  EXPECT_EQ(csv.file_position, position);
  EXPECT_EQ(csv.label, labels);
}

TEST(FileFormat, ValuesThatDoNotFitTheirFieldOfLasAreExtraDimensions) {
  Cloud cloud = camera_cloud(2, 1);
  const std::vector<Attribute> attributes{
      attribute<float>("intensity", ScalarType::kFloat32, {0.5, 2}),
      attribute<std::uint8_t>("return_number", ScalarType::kUint8, {1, 16}),
      attribute<float>("scan_angle", ScalarType::kFloat32, {-9, 12}),
      attribute<float>("normal", ScalarType::kFloat32, {0, 0, 1, 1, 0, 0}, 3),
      attribute<std::uint8_t>("code", ScalarType::kUint8, {1, 2, 3, 4, 5, 6, 7, 8}, 4)};
  const LabeledCloud again = read(write({.cloud = cloud, .attributes = attributes}, FileFormat::kLas));
  for (std::size_t i = 0; i < 4; ++i) {
    const Attribute* const found = find(again, attributes[i].name);
    ASSERT_NE(found, nullptr) << attributes[i].name;
    EXPECT_EQ(found->type, attributes[i].type);
    EXPECT_EQ(found->values, attributes[i].values) << attributes[i].name;
  }
  ASSERT_NE(find(again, "code_3"), nullptr);
  EXPECT_THAT(find(again, "code_3")->values, ElementsAre(std::byte{4}, std::byte{8}));
}

TEST(FileFormat, LasLeavesOutPointsThatAreNotFinite) {
  Cloud cloud = camera_cloud(3, 1);
  cloud.y[1] = std::numeric_limits<float>::quiet_NaN();
  const std::vector<std::uint32_t> labels{1, 0, 2};
  const auto file = encode_file({.cloud = cloud, .label = labels}, FileFormat::kLas);
  ASSERT_TRUE(file.ok()) << file.status();
  ASSERT_EQ(file->warnings.size(), 1U);
  EXPECT_THAT(file->warnings[0].message, HasSubstr("1 points that are not finite are left out"));
  EXPECT_THAT(read(file->bytes).label, ElementsAre(1, 2));
  EXPECT_EQ(read(write({.cloud = Cloud{}}, FileFormat::kLas)).cloud.size(), 0U);
}

TEST(FileFormat, NpyKeepsRowsAndPointsThatAreNotFinite) {
  const Sample sample = make_sample(1, 5, 4, true, true);
  const LabeledCloud again = read(write({.cloud = sample.cloud, .label = sample.label}, FileFormat::kNpy));
  expect_same_points(again.cloud, sample.cloud);
  EXPECT_EQ(again.cloud.width, 5U);
  EXPECT_EQ(again.cloud.height, 4U);
}

std::vector<std::string> warnings_of(const FileContent& content, FileFormat format) {
  const auto file = encode_file(content, format);
  EXPECT_TRUE(file.ok()) << file.status();
  std::vector<std::string> messages;
  for (const Warning& warning : file.ok() ? file->warnings : std::vector<Warning>())
    messages.push_back(warning.message);
  return messages;
}

TEST(FileFormat, RowsAndColumnsThatAFormatCannotHoldAreMentioned) {
  const Cloud organized = camera_cloud(3, 2), row = camera_cloud(6, 1);
  for (const FileFormat format : kClouds) {
    SCOPED_TRACE(static_cast<int>(format));
    EXPECT_TRUE(warnings_of({.cloud = row}, format).empty());
    const auto warnings = warnings_of({.cloud = organized}, format);
    if (format == FileFormat::kPcd || format == FileFormat::kNpy) {
      EXPECT_TRUE(warnings.empty());
    } else {
      EXPECT_THAT(warnings, ElementsAre(HasSubstr("the rows and columns of the organized cloud (3 x 2) are not kept")));
    }
  }
}

TEST(FileFormat, TheViewpointOfAPcdFileIsKeptInPcdAndMentionedElsewhere) {
  const auto pcd = [](std::string_view size, std::string_view viewpoint, std::string_view comment) {
    std::string rows;
    for (int v = 0; v < 4; ++v) {
      for (int u = 0; u < 6; ++u) rows += fmt::format("{} {} 1\n", 0.01 * (u - 2.5), 0.01 * (v - 1.5));
    }
    return fmt::format("{}FIELDS x y z\nSIZE 8 8 8\nTYPE F F F\n{}\nVIEWPOINT {}\nPOINTS 24\nDATA ascii\n{}", comment,
                       size, viewpoint, rows);
  };
  struct Case {
    std::string_view size, viewpoint, comment;
    bool is_in_the_view;
  };
  for (const Case& c : {Case{"WIDTH 24\nHEIGHT 1", "0 0 3 0.5 -0.5 0.5 -0.5", "", false},
                        Case{"WIDTH 6\nHEIGHT 4", "1 2 3 0.5 -0.5 0.5 -0.5", "", false},
                        Case{"WIDTH 6\nHEIGHT 4", "0.1 0.2 0.3 1 0 0 0", "# segserve view camera\n", false},
                        Case{"WIDTH 24\nHEIGHT 1", "0.1 0.2 -3 1 0 0 0", "# segserve view world\n", false},
                        Case{"WIDTH 24\nHEIGHT 1", "389425.37 5819321.62 40.13 1 0 0 0", "", true}}) {
    const LabeledCloud cloud = read(pcd(c.size, c.viewpoint, c.comment));
    const FileContent content = content_of(cloud, {});
    EXPECT_THAT(write(content, FileFormat::kPcd), HasSubstr(fmt::format("\nVIEWPOINT {}\n", c.viewpoint)));
    for (const FileFormat format : kClouds) {
      SCOPED_TRACE(fmt::format("{} {}", c.viewpoint, static_cast<int>(format)));
      const bool is_lost = format != FileFormat::kPcd && !c.is_in_the_view;
      const auto is_about_viewpoint = HasSubstr("the file's VIEWPOINT is not kept; PCD keeps it");
      const auto warnings = warnings_of(content, format);
      EXPECT_EQ(testing::Value(warnings, testing::Contains(is_about_viewpoint)), is_lost);
    }
  }
  // A place that was given instead of the file's is written, and the file's is mentioned.
  LabeledCloud other = read(pcd("WIDTH 24\nHEIGHT 1", "0 0 3 0.5 -0.5 0.5 -0.5", ""));
  other.cloud.view = View::world(0, 0, -2);
  const FileContent content = content_of(other, {});
  EXPECT_THAT(write(content, FileFormat::kPcd), HasSubstr("\nVIEWPOINT 0 0 -2 1 0 0 0\n"));
  EXPECT_THAT(losses_of(content, FileFormat::kPcd).at(0).message, HasSubstr("another place of the sensor was given"));
}

TEST(FileFormat, IntegersThatPlyRoundsAreMentioned) {
  const Cloud cloud = camera_cloud(2, 1);
  constexpr std::int64_t kExact = std::int64_t{1} << 60U;
  const std::vector<Attribute> attributes{
      attribute<std::int64_t>("stamp", ScalarType::kInt64, {1'700'000'000'123'456'789, -1}),
      attribute<std::uint64_t>("id", ScalarType::kUint64, {std::numeric_limits<std::uint64_t>::max(), 1U << 31U}),
      attribute<std::int64_t>("most", ScalarType::kInt64, {0, std::numeric_limits<std::int64_t>::max()}),
      attribute<std::int64_t>("exact", ScalarType::kInt64, {kExact, std::numeric_limits<std::int64_t>::min()})};
  const FileContent content{.cloud = cloud, .attributes = attributes};
  for (const FileFormat format : kClouds) {
    SCOPED_TRACE(static_cast<int>(format));
    if (format == FileFormat::kPly) {
      EXPECT_THAT(warnings_of(content, format),
                  ElementsAre(HasSubstr("1 of 2 values of 'stamp' are rounded"), HasSubstr("of 'id' are rounded"),
                              HasSubstr("of 'most' are rounded")));
    } else {
      EXPECT_TRUE(warnings_of(content, format).empty());
      EXPECT_EQ(find(read(write(content, format)), "stamp")->values, attributes[0].values);
    }
  }
}

TEST(FileFormat, TheUnitSurvives) {
  const std::string millimeters = "x_mm,y_mm,z_mm\n0,0,700\n10,0,700\n0,10,710\n";
  const LabeledCloud first = read(millimeters);
  for (const FileFormat format : kClouds) {
    SCOPED_TRACE(static_cast<int>(format));
    const std::string file = write(content_of(first, {}), format);
    const LabeledCloud again = read(file);
    EXPECT_EQ(again.placement.meters_per_unit(), 0.001);
    EXPECT_NEAR(again.file_position[2][0], 700, 1e-9);
    EXPECT_EQ(again.cloud.view, first.cloud.view);
    ASSERT_EQ(again.warnings.size(), 1U);
    EXPECT_EQ(again.warnings[0].reason, WarningReason::kUnitGuessed);
    EXPECT_EQ(again.warnings[0].message, "the coordinates are taken as mm, as the file says");
    const auto given = decode_cloud(bytes_of(file), {}, {.unit = LengthUnit::kCentimeter});
    ASSERT_TRUE(given.ok()) << given.status();
    EXPECT_EQ(given->placement.meters_per_unit(), 0.01);
    EXPECT_TRUE(given->warnings.empty());
  }
}

TEST(FileFormat, AUnitThatIsNoneIsNotTaken) {
  for (const std::string unit : {"auto", "km", "", "mm mm"}) {
    const LabeledCloud cloud = read("# segserve unit " + unit + "\nx,y,z\n1,2,3\n4,5,6\n");
    EXPECT_EQ(cloud.placement.meters_per_unit(), 1) << unit;
  }
  const LabeledCloud meters = read("# segserve unit m\nx,y,z\n1,2,3\n4,5,6\n");
  EXPECT_TRUE(meters.warnings.empty()) << "everybody expects meters";
}

TEST(FileFormat, ListsOfLabelsHaveTheFormOfTheirDataSets) {
  const Cloud cloud = camera_cloud(3, 1);
  const std::vector<std::uint32_t> labels{1, 0, 65535}, large{1, 65536, 0};
  const auto segs = encode_file({.cloud = cloud, .label = labels}, FileFormat::kSegsJson, {}, "scene\"1");
  EXPECT_EQ(segs->bytes, "{\"params\": {}, \"sceneId\": \"scene\\\"1\", \"segIndices\": [1, 0, 65535]}\n");
  const auto kitti = encode_file({.cloud = cloud, .label = labels}, FileFormat::kKittiLabel);
  EXPECT_EQ(kitti->bytes, std::string("\0\0\1\0\0\0\0\0\0\0\xff\xff", 12));
  expect_fault(encode_file({.cloud = cloud, .label = large}, FileFormat::kKittiLabel).status(),
               "SemanticKITTI has 16 bits for an instance, and point 1 (counted from 0) has label 65536");
  expect_fault(encode_file({.cloud = cloud}, FileFormat::kSegsJson).status(), "nothing but labels");
}

TEST(FileFormat, GltfHasANodeForEachSegmentWithYUp) {
  Cloud cloud = camera_cloud(4, 1);
  cloud.x = {1, 4, 7, 10}, cloud.y = {2, 5, 8, 11}, cloud.z = {3, 6, 9, std::numeric_limits<float>::quiet_NaN()};
  cloud.rgb = {pack_rgb(1, 2, 3), pack_rgb(4, 5, 6), pack_rgb(7, 8, 9), 0};
  const std::vector<std::uint32_t> labels{2, 0, 2, 1};
  for (const auto& [view, y, z] : {std::tuple{View::world(), 6.0F, -5.0F}, {View::camera(), -5.0F, -6.0F}}) {
    cloud.view = view;
    const auto file = encode_file({.cloud = cloud, .label = labels}, FileFormat::kGlb);
    ASSERT_TRUE(file.ok()) << file.status();
    ASSERT_EQ(file->warnings.size(), 1U);
    const std::string& bytes = file->bytes;
    std::array<std::uint32_t, 5> head{};
    std::memcpy(head.data(), bytes.data(), sizeof head);
    EXPECT_THAT(head, ElementsAre(0x46546C67, 2, bytes.size(), testing::Gt(0), 0x4E4F534A));
    ASSERT_EQ(head[3] % 4, 0U);
    const std::string json = bytes.substr(20, head[3]), numbers = bytes.substr(28 + head[3]);
    ASSERT_EQ(numbers.size(), 3U * 16);
    EXPECT_THAT(json, HasSubstr("\"nodes\":[{\"name\":\"unlabeled\",\"mesh\":0},{\"name\":\"segment 2\",\"mesh\":1}]"));
    EXPECT_THAT(json, HasSubstr("\"byteOffset\":12,\"componentType\":5126,\"count\":2,\"type\":\"VEC3\""));
    std::array<float, 3> first{};
    std::memcpy(first.data(), numbers.data(), sizeof first);
    EXPECT_THAT(first, ElementsAre(4, y, z));
    EXPECT_EQ(numbers.substr(36, 4), "\4\5\6\xff");
  }
  const auto text = encode_file({.cloud = cloud, .label = labels}, FileFormat::kGltf);
  EXPECT_THAT(text->bytes, HasSubstr("\"byteLength\":48,\"uri\":\"data:application/octet-stream;base64,"));
}

TEST(FileFormat, TheEndOfTheNameChooses) {
  EXPECT_EQ(file_format_of("a.LAS"), FileFormat::kLas);
  EXPECT_EQ(file_format_of("folder/a.segs.json"), FileFormat::kSegsJson);
  EXPECT_EQ(file_format_of("a.json"), std::nullopt);
  EXPECT_EQ(scene_name("folder/scene0000_00.segs.json"), "scene0000_00");
  EXPECT_TRUE(has_readable_extension("a.b.LAS.GZ"));
  EXPECT_TRUE(has_readable_extension("a.npz"));
  EXPECT_FALSE(has_readable_extension("a.json"));
  EXPECT_FALSE(has_readable_extension("a.gz"));
  EXPECT_THAT(writable_extensions(), HasSubstr(".segs.json, .label, .glb or .gltf"));
}

}  // namespace
}  // namespace segserve::codec
