// SPDX-License-Identifier: Apache-2.0
#include <filesystem>
#include <fstream>
#include <sstream>

#include "segserve/codec/cloud_file.hpp"
#include "segserve/codec/file_format.hpp"
#include "test/core/codec/support/las_file.hpp"
#include "test/core/codec/support/sample_cloud.hpp"

namespace segserve::codec {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

LabeledCloud decode(const std::string& file) {
  auto cloud = decode_cloud(bytes_of(file), {}, {.keep_everything = true});
  EXPECT_TRUE(cloud.ok()) << cloud.status();
  return cloud.ok() ? *std::move(cloud) : LabeledCloud{};
}

template <typename T>
T value_of(const LabeledCloud& cloud, std::string_view name, std::size_t number = 0) {
  for (const Attribute& attribute : cloud.attributes) {
    if (attribute.name != name) continue;
    EXPECT_EQ(size_of(attribute.type), sizeof(T)) << name;
    T value;
    std::memcpy(&value, attribute.values.data() + number * sizeof(T), sizeof value);
    return value;
  }
  ADD_FAILURE() << "there is no " << name;
  return {};
}

TEST(Las, EveryPointFormatHasItsLayout) {
  constexpr std::array<std::size_t, 11> kBytes{20, 28, 26, 34, 57, 63, 30, 36, 38, 59, 67};
  constexpr std::array<int, 11> kColor{-1, -1, 20, 28, -1, 28, -1, 30, 30, -1, 30};
  constexpr std::array<int, 11> kTime{-1, 20, -1, 20, 20, 20, 22, 22, 22, 22, 22};
  for (unsigned format = 0; format <= 10; ++format) {
    SCOPED_TRACE(format);
    LasFile file = las_file(4, format, kBytes[format], 2);
    const std::size_t second = kBytes[format];
    put<std::uint16_t>(file.body, second + 12, 777);
    if (kColor[format] >= 0) {
      const std::size_t at = second + static_cast<std::size_t>(kColor[format]);
      put<std::uint16_t>(file.body, at, 65535);
      put<std::uint16_t>(file.body, at + 2, 257 * 128);
      put<std::uint16_t>(file.body, at + 4, 257 * 3);
    }
    if (kTime[format] >= 0) put(file.body, second + static_cast<std::size_t>(kTime[format]), 12345.5);
    const LabeledCloud cloud = decode(file.bytes());
    ASSERT_EQ(cloud.cloud.size(), 2U);
    EXPECT_THAT(cloud.cloud.x, ElementsAre(1, 2));
    EXPECT_THAT(cloud.cloud.y, ElementsAre(2, 4));
    EXPECT_THAT(cloud.cloud.z, ElementsAre(3, 6));
    EXPECT_EQ(value_of<std::uint16_t>(cloud, "intensity", 1), 777);
    if (kColor[format] >= 0) {
      EXPECT_EQ(cloud.cloud.rgb, (std::vector<std::uint32_t>{0, pack_rgb(255, 128, 3)}));
    }
    EXPECT_EQ(cloud.cloud.has_color(), kColor[format] >= 0);
    if (kTime[format] >= 0) {
      EXPECT_EQ(value_of<double>(cloud, "gps_time", 1), 12345.5);
    }
    const bool has_waveform = format == 4 || format == 5 || format >= 9;
    EXPECT_EQ(cloud.warnings.size(), has_waveform ? 1U : 0U);
  }
}

TEST(Las, ValuesThatShareBytesAreTakenApart) {
  LasFile old = las_file(2, 0, 20, 1);
  put<std::uint8_t>(old.body, 14, 0b1'0'011'101);
  put<std::uint8_t>(old.body, 15, 0b010'00110);
  put<std::int8_t>(old.body, 16, -9);
  const LabeledCloud a = decode(old.bytes());
  EXPECT_EQ(value_of<std::uint8_t>(a, "return_number"), 5);
  EXPECT_EQ(value_of<std::uint8_t>(a, "number_of_returns"), 3);
  EXPECT_EQ(value_of<std::uint8_t>(a, "edge_of_flight_line"), 1);
  EXPECT_EQ(value_of<std::uint8_t>(a, "classification"), 6);
  EXPECT_EQ(value_of<std::uint8_t>(a, "classification_flags"), 2);
  EXPECT_EQ(value_of<float>(a, "scan_angle"), -9);
  EXPECT_EQ(a.attributes.size(), 6U) << "values that are 0 for all points are left out";

  LasFile recent = las_file(4, 6, 30, 1);
  put<std::uint8_t>(recent.body, 14, 0x3C);
  put<std::uint8_t>(recent.body, 15, 0b01'10'1000);
  put<std::uint8_t>(recent.body, 16, 200);
  put<std::int16_t>(recent.body, 18, -1500);
  const LabeledCloud b = decode(recent.bytes());
  EXPECT_EQ(value_of<std::uint8_t>(b, "return_number"), 12);
  EXPECT_EQ(value_of<std::uint8_t>(b, "number_of_returns"), 3);
  EXPECT_EQ(value_of<std::uint8_t>(b, "classification_flags"), 8);
  EXPECT_EQ(value_of<std::uint8_t>(b, "scanner_channel"), 2);
  EXPECT_EQ(value_of<std::uint8_t>(b, "scan_direction"), 1);
  EXPECT_EQ(value_of<std::uint8_t>(b, "classification"), 200);
  EXPECT_EQ(value_of<float>(b, "scan_angle"), -9);
}

TEST(Las, ExtraDimensionsAreAttributesAndASegmentIsTheLabel) {
  std::string scaled = las_extra("height", 4, 8 | 16);
  put(scaled, 112, 0.5);
  put(scaled, 136, 10.0);
  const std::string descriptions = las_extra("segment", 5) + scaled + las_extra("normal", 29) + las_extra("x", 1);
  LasFile file = las_file(2, 0, 20 + 4 + 2 + 12 + 1 + 3, 1);
  file.records = las_record("LASF_Spec", 4, descriptions) + las_record("segserve", 1, "segserve view world 1 2 3");
  file.record_count = 2;
  put<std::uint32_t>(file.body, 20, 42);
  put<std::int16_t>(file.body, 24, -4);
  for (std::size_t k = 0; k < 3; ++k) put(file.body, 26 + 4 * k, 0.25F * static_cast<float>(k));
  put<std::uint8_t>(file.body, 38, 9);
  const LabeledCloud cloud = decode(file.bytes());
  EXPECT_THAT(cloud.label, ElementsAre(42));
  EXPECT_EQ(value_of<double>(cloud, "height"), 8);
  EXPECT_EQ(value_of<float>(cloud, "normal", 2), 0.5F);
  EXPECT_EQ(value_of<std::uint8_t>(cloud, "x"), 9);
  EXPECT_EQ(cloud.cloud.view, View::world(1, 2, 3));
  ASSERT_EQ(cloud.warnings.size(), 1U);
  EXPECT_THAT(cloud.warnings[0].message, HasSubstr("the last 3 bytes of each point are not kept"));
  EXPECT_THAT(decode_cloud(bytes_of(file.bytes()), {})->attributes, IsEmpty());
}

TEST(Las, TheNameOfALabelIsOfAnyCase) {
  LasFile file = las_file(2, 0, 22, 1);
  file.records = las_record("LASF_Spec", 4, las_extra("Label", 3));
  file.record_count = 1;
  file.body[20] = 7;
  EXPECT_THAT(decode(file.bytes()).label, ElementsAre(7));
}

TEST(Las, FarCoordinatesStayExact) {
  LasFile file = las_file(2, 0, 20, 2);
  std::string bytes = file.bytes();
  put(bytes, 155, 500000.0);
  put(bytes, 163, 5800000.0);
  const LabeledCloud cloud = decode(bytes);
  EXPECT_EQ(cloud.cloud.x[1] - cloud.cloud.x[0], 1);
  EXPECT_EQ(cloud.file_position[1], (std::vector<double>{5800000, 5800002}));
}

TEST(Las, TheKindOfGpsTimeGoesOutAgain) {
  for (const bool is_standard : {false, true}) {
    LasFile file = las_file(2, 1, 28, 2);
    put(file.body, 20, 3.5e8);
    std::string bytes = file.bytes();
    put<std::uint16_t>(bytes, 6, is_standard ? 1 : 0);
    const LabeledCloud cloud = decode(bytes);
    EXPECT_EQ(cloud.has_standard_gps_time, is_standard);
    const auto written = encode_file(content_of(cloud, {}), FileFormat::kLas, FileEncoding::kBinary, "");
    ASSERT_TRUE(written.ok()) << written.status();
    EXPECT_EQ(static_cast<unsigned char>(written->bytes[6]), is_standard ? 0x11 : 0x10);
    EXPECT_EQ(decode(written->bytes).has_standard_gps_time, is_standard);
  }
}

TEST(Las, NoPointsAreNoFault) { EXPECT_EQ(decode(las_file(2, 1, 28, 0).bytes()).cloud.size(), 0U); }

// The files of other programs in shared/data/las.
TEST(Las, FilesOfOthersAreReadOrRefusedInWords) {
  const std::filesystem::path folder = std::filesystem::path(SEGSERVE_DATA_DIR) / "las";
  if (!std::filesystem::exists(folder)) GTEST_SKIP() << "there is no " << folder;
  const std::vector<std::pair<std::string, std::size_t>> expected{{"1.2-with-color.las", 1065},
                                                                  {"garbage_nVariableLength.las", 718},
                                                                  {"gps-time-nan.las", 1},
                                                                  {"no-points.las", 0},
                                                                  {"spec_3.las", 10},
                                                                  {"test1_4.las", 1000},
                                                                  {"utm15.las", 1},
                                                                  {"permutation_1.0_1.las", 1},
                                                                  {"permutation_1.2_3.las", 1}};
  for (const auto& [name, points] : expected) {
    SCOPED_TRACE(name);
    const auto cloud = load_cloud(folder / name, {.keep_everything = true});
    ASSERT_TRUE(cloud.ok()) << cloud.status();
    EXPECT_EQ(cloud->cloud.size(), points);
    for (const float x : cloud->cloud.x) EXPECT_TRUE(std::isfinite(x));
  }
  for (const std::string name : {"simple.laz", "laszip-generated.laz", "1.2-with-color.copc.laz"}) {
    expect_fault(load_cloud(folder / name).status(), "this is LAZ, or COPC");
  }
  expect_fault(load_cloud(folder / "A4.e57").status(), "this is E57");
  expect_fault(load_cloud(folder / "spurious.las").status(), "latitudes and longitudes are no coordinates");
  EXPECT_EQ(load_cloud(folder / "test1_4.las")->placement.meters_per_unit(), 0.3048) << "US survey feet";
  const auto colored = load_cloud(folder / "1.2-with-color.las", {.keep_everything = true});
  EXPECT_NEAR(colored->file_position[0][0], 637012.24, 1e-6);
  EXPECT_NEAR(colored->file_position[1][0], 849028.31, 1e-6);
  EXPECT_EQ(colored->cloud.rgb[0], pack_rgb(68, 77, 88));
}

}  // namespace
}  // namespace segserve::codec
