// SPDX-License-Identifier: Apache-2.0
// What LAS files tell of their coordinate reference system: its unit, and whether it has degrees.

#include <array>
#include <tuple>
#include <utility>

#include "core/codec/las/las.hpp"
#include "test/core/codec/support/las_file.hpp"
#include "test/core/codec/support/sample_cloud.hpp"

namespace segserve::codec {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

constexpr std::string_view kProjection = "LASF_Projection";
constexpr std::uint16_t kDirectory = 34735, kDoubles = 34736, kText = 2112;

using Key = std::array<std::uint16_t, 4>;

std::string words(const std::vector<std::uint16_t>& numbers) {
  return {reinterpret_cast<const char*>(numbers.data()), numbers.size() * sizeof(std::uint16_t)};
}

/// The payload of a directory of GeoKeys.
std::string directory(const std::vector<Key>& keys) {
  std::vector<std::uint16_t> numbers{1, 1, 0, static_cast<std::uint16_t>(keys.size())};
  for (const Key& key : keys) numbers.insert(numbers.end(), key.begin(), key.end());
  return words(numbers);
}

/// A projected system whose linear unit has this number.
std::string projected(std::uint16_t unit) { return directory({{1024, 0, 1, 1}, {3076, 0, 1, unit}}); }

std::string with_record(std::uint16_t id, std::string_view payload) {
  LasFile file = las_file(4, 6, 30, 3);
  file.records = las_record(kProjection, id, payload);
  file.record_count = 1;
  return file.bytes();
}

std::string with_extended_record(std::uint16_t id, std::string_view payload) {
  std::string bytes = las_file(4, 6, 30, 3).bytes();
  put(bytes, 235, std::uint64_t{bytes.size()});
  put(bytes, 243, std::uint32_t{1});
  return bytes + las_extended_record(kProjection, id, payload);
}

LabeledCloud read_las(const std::string& file, const ReadOptions& options = {}) {
  auto cloud = decode_las(bytes_of(file), {}, options);
  EXPECT_TRUE(cloud.ok()) << cloud.status();
  return cloud.ok() ? *std::move(cloud) : LabeledCloud{};
}

std::vector<std::string> messages(const LabeledCloud& cloud) {
  std::vector<std::string> all;
  all.reserve(cloud.warnings.size());
  for (const Warning& warning : cloud.warnings) all.push_back(warning.message);
  return all;
}

constexpr std::string_view kGeographic =
    "GEOGCS[\"WGS 84\",DATUM[\"WGS_1984\",SPHEROID[\"WGS 84\",6378137,298.257223563]],PRIMEM[\"Greenwich\",0],"
    "UNIT[\"degree\",0.0174532925199433,AUTHORITY[\"EPSG\",\"9122\"]]]";

/// A projected system as text, with a unit of so many meters.
std::string projected_text(std::string_view unit) {
  return "PROJCS[\"a [b, c]\"," + std::string(kGeographic) +
         ",PROJECTION[\"Transverse_Mercator\"],PARAMETER[\"false_easting\",1640416.67],UNIT[" + std::string(unit) +
         ",AUTHORITY[\"EPSG\",\"9003\"]],AXIS[\"X\",EAST],AUTHORITY[\"EPSG\",\"2903\"]]";
}

std::string text_of_two(std::string_view unit, std::string_view height_unit) {
  return "COMPD_CS[\"both\"," + projected_text(unit) + ",VERT_CS[\"NAVD88\",VERT_DATUM[\"x\",2005],UNIT[" +
         std::string(height_unit) + "],AXIS[\"Up\",UP]]]";
}

constexpr std::string_view kNew =
    "BOUNDCRS[SOURCECRS[PROJCRS[\"NAD83 / Texas\",BASEGEOGCRS[\"NAD83\",DATUM[\"x\",ELLIPSOID[\"GRS "
    "1980\",6378137,298.25,LENGTHUNIT[\"metre\",1]]],PRIMEM[\"Greenwich\",0,ANGLEUNIT[\"degree\",0.0174532925]]],"
    "CONVERSION[\"y\",PARAMETER[\"False easting\",600000,LENGTHUNIT[\"metre\",1]]],CS[Cartesian,2],"
    "AXIS[\"easting (X)\",east,ORDER[1],LENGTHUNIT[\"foot\",0.3048]],"
    "AXIS[\"northing (Y)\",north,ORDER[2],LENGTHUNIT[\"foot\",0.3048]]]],"
    "TARGETCRS[GEOGCRS[\"WGS 84\",CS[ellipsoidal,2],AXIS[\"lat\",north],UNIT[\"metre\",1]]]]";

TEST(ReferenceSystem, ItsUnitIsThatOfTheCoordinates) {
  const std::string as_it_says = "the coordinates are taken as ft, as the coordinate reference system says";
  const std::string survey = "though the coordinate reference system says US survey feet";
  const std::vector<std::tuple<std::uint16_t, std::string, std::string>> cases{
      {kDirectory, projected(9002), as_it_says},
      {kDirectory, projected(9003), survey},
      {kText, projected_text("\"Foot\",0.3048"), as_it_says},
      {kText, projected_text("\"US survey foot\", 0.3048006096012192"), survey},
      {kText, text_of_two("\"Foot_US\",0.30480061", "\"foot\",0.3048"), survey},
      {kDirectory, directory({{1024, 0, 1, 1}, {3076, 0, 1, 9003}, {4099, 0, 1, 9002}}), survey},
      {kText, std::string(kNew) + '\0', as_it_says}};
  for (const auto& [id, payload, said] : cases) {
    SCOPED_TRACE(payload);
    for (const std::string& file : {with_record(id, payload), with_extended_record(id, payload)}) {
      const LabeledCloud cloud = read_las(file);
      EXPECT_EQ(cloud.placement.meters_per_unit(), 0.3048);
      EXPECT_THAT(messages(cloud), ElementsAre(HasSubstr(said)));
      EXPECT_EQ(cloud.warnings.at(0).reason, WarningReason::kUnitGuessed);
      const LabeledCloud given = read_las(file, {.unit = LengthUnit::kMeter});
      EXPECT_EQ(given.placement.meters_per_unit(), 1);
      EXPECT_THAT(messages(given), IsEmpty());
    }
  }
}

TEST(ReferenceSystem, MetersAreNotMentioned) {
  const std::vector<std::pair<std::uint16_t, std::string>> cases{
      {kDirectory, projected(9001)},
      {kDirectory, directory({{1024, 0, 1, 1}, {3072, 0, 1, 26915}})},
      {kDirectory, projected(0)},
      {kText, text_of_two("\"metre\",1", "\"meter\",1.0")},
      {kDirectory, directory({{1024, 0, 1, 1}, {3072, 0, 1, 26915}, {4099, 0, 1, 9001}})},
      {kText, "GEODCRS[\"WGS 84\",CS[Cartesian,3],AXIS[\"(X)\",geocentricX],LENGTHUNIT[\"metre\",1]]"},
      {kText, "VERT_CS[\"x\",UNIT[\"metre\",1]]"},
      {kText, ""}};
  for (const auto& [id, payload] : cases) {
    const LabeledCloud cloud = read_las(with_record(id, payload));
    EXPECT_EQ(cloud.placement.meters_per_unit(), 1) << payload;
    EXPECT_THAT(messages(cloud), IsEmpty()) << payload;
  }
}

TEST(ReferenceSystem, HeightsInAnotherUnitAreMentioned) {
  const std::string axes_of_three =
      "PROJCRS[\"x\",CS[Cartesian,3],AXIS[\"E\",east,LENGTHUNIT[\"metre\",1]],AXIS[\"N\",north,LENGTHUNIT[\"metre\",1]]"
      ","
      "AXIS[\"h\",up,LENGTHUNIT[\"foot\",0.3048]]]";
  const std::vector<std::tuple<std::uint16_t, std::string, double, std::string>> cases{
      {kText, text_of_two("\"metre\",1", "\"foot\",0.3048"), 1, "taken as m, as x and y are, though"},
      {kText, text_of_two("\"metre\",1", "\"Foot_US\",0.304800609601219"), 1, "has US survey feet for them"},
      {kText, text_of_two("\"foot\",0.3048", "\"metre\",1"), 0.3048, "taken as ft, as x and y are, though"},
      {kText, "VERT_CS[\"x\",UNIT[\"foot\",0.3048]]", 1, "has ft for them"},
      {kText, axes_of_three, 1, "has ft for them; save all three in one unit"},
      {kDirectory, directory({{1024, 0, 1, 1}, {3072, 0, 1, 26910}, {4099, 0, 1, 9003}}), 1, "US survey feet"},
      {kDirectory, directory({{1024, 0, 1, 1}, {3076, 0, 1, 9002}, {4099, 0, 1, 9001}}), 0.3048, "has m for them"}};
  for (const auto& [id, payload, meters, said] : cases) {
    SCOPED_TRACE(payload);
    const LabeledCloud cloud = read_las(with_record(id, payload));
    EXPECT_EQ(cloud.placement.meters_per_unit(), meters);
    EXPECT_THAT(messages(cloud), testing::Contains(testing::AllOf(HasSubstr("the heights are"), HasSubstr(said))));
    EXPECT_EQ(cloud.warnings.at(0).reason, WarningReason::kUnitGuessed);
    EXPECT_THAT(messages(read_las(with_record(id, payload), {.unit = LengthUnit::kMeter})), IsEmpty());
  }
}

TEST(ReferenceSystem, AUnitThatIsNotKnownIsMentioned) {
  for (const auto& [id, payload] :
       {std::pair(kText, projected_text("\"yard\",0.9144")), std::pair(kText, projected_text("\"none\",0")),
        std::pair(kDirectory, projected(9014))}) {
    const LabeledCloud cloud = read_las(with_record(id, payload));
    EXPECT_EQ(cloud.placement.meters_per_unit(), 1);
    EXPECT_THAT(messages(cloud), ElementsAre(HasSubstr("are taken as m, though the coordinate reference system has")));
  }
}

TEST(ReferenceSystem, AUnitMayBeANumberInAnotherRecord) {
  LasFile file = las_file(2, 0, 20, 3);
  std::string doubles(16, '\0');
  put(doubles, 8, 0.01);
  file.records =
      las_record(kProjection, kDoubles, doubles) +
      las_record(kProjection, kDirectory, directory({{1024, 0, 1, 1}, {3076, 0, 1, 32767}, {3077, kDoubles, 1, 1}}));
  file.record_count = 2;
  EXPECT_EQ(read_las(file.bytes()).placement.meters_per_unit(), 0.01);
}

TEST(ReferenceSystem, TheHeaderTellsWhichRecordCounts) {
  LasFile file = las_file(4, 6, 30, 3);
  file.records = las_record(kProjection, kText, projected_text("\"metre\",1")) +
                 las_record(kProjection, kDirectory, projected(9002));
  file.record_count = 2;
  std::string bytes = file.bytes();
  EXPECT_EQ(read_las(bytes).placement.meters_per_unit(), 0.3048);
  put<std::uint16_t>(bytes, 6, 0x10);
  EXPECT_EQ(read_las(bytes).placement.meters_per_unit(), 1);
}

TEST(ReferenceSystem, LatitudesAndLongitudesAreRefused) {
  const std::string geographic = directory({{1024, 0, 1, 2}, {2048, 0, 1, 4326}});
  for (const auto& [id, payload] : {std::pair(kDirectory, geographic), std::pair(kText, std::string(kGeographic))}) {
    for (std::string file : {with_record(id, payload), with_extended_record(id, payload)}) {
      expect_fault(decode_las(bytes_of(file), {}).status(),
                   "latitudes and longitudes are no coordinates in meters; project them first, for example to UTM");
      EXPECT_THAT(messages(read_las(file, {.unit = LengthUnit::kMeter})), IsEmpty()) << "the reader knows better";
      put(file, 155, 637012.0);
      EXPECT_THAT(messages(read_las(file)), ElementsAre(HasSubstr("because they reach to 637014")));
    }
  }
  LasFile empty = las_file(4, 6, 30, 0);
  empty.records = las_record(kProjection, kDirectory, geographic);
  empty.record_count = 1;
  EXPECT_EQ(read_las(empty.bytes()).cloud.size(), 0U);
}

TEST(ReferenceSystem, DamagedRecordsAreNotUsed) {
  const std::string cut = projected(9002);
  const std::vector<std::pair<std::uint16_t, std::string>> cases{
      {kDirectory, ""},
      {kDirectory, cut.substr(0, cut.size() - 1)},
      {kDirectory, words({1, 1, 0, 65535, 3076, 0, 1, 9002})},
      {kDirectory, directory({{1024, 0, 1, 1}, {3077, kDoubles, 1, 0}})},
      {kText, "PROJCS[\"a\",UNIT[\"foot\",0.3048]"},
      {kText, "PROJCS[\"a\",UNIT[\"foot\",0.3048]]]"},
      {kText, "PROJCS[\"a,UNIT[foot,0.3048]]"},
      {kText, std::string(60'000, '[')}};
  for (const auto& [id, payload] : cases) {
    const LabeledCloud cloud = read_las(with_record(id, payload));
    EXPECT_EQ(cloud.placement.meters_per_unit(), 1);
    EXPECT_THAT(messages(cloud),
                ElementsAre(HasSubstr("is damaged, so that the unit of the coordinate reference system is not used")));
  }
  const std::string longer = projected_text("\"foot\",0.3048") + std::string(70'000, ' ');
  EXPECT_THAT(messages(read_las(with_extended_record(kText, longer))), ElementsAre(HasSubstr("is damaged")));
}

/// The file that a cloud is written to as LAS.
EncodedFile written(const LabeledCloud& cloud) {
  auto file = encode_las(content_of(cloud, {}));
  EXPECT_TRUE(file.ok()) << file.status();
  return file.ok() ? *std::move(file) : EncodedFile{};
}

std::vector<std::pair<std::uint16_t, std::string>> records_of(const LabeledCloud& cloud) {
  std::vector<std::pair<std::uint16_t, std::string>> all;
  all.reserve(cloud.reference_records.size());
  for (const ReferenceRecord& record : cloud.reference_records) all.emplace_back(record.id, record.payload);
  return all;
}

bool says_that_it_is_text(const std::string& file) { return (static_cast<unsigned char>(file[6]) & 0x10U) != 0; }

TEST(ReferenceSystem, GoesIntoLasAgainWhereverItStood) {
  const std::string text = projected_text("\"metre\",1");
  for (const std::string& file : {with_record(kText, text), with_extended_record(kText, text)}) {
    const EncodedFile again = written(read_las(file, {.keep_everything = true}));
    EXPECT_THAT(again.warnings, IsEmpty());
    EXPECT_TRUE(says_that_it_is_text(again.bytes));
    EXPECT_THAT(records_of(read_las(again.bytes, {.keep_everything = true})), ElementsAre(std::pair(kText, text)));
  }
  EXPECT_THAT(records_of(read_las(with_record(kText, text))), IsEmpty()) << "it was not asked for";
}

TEST(ReferenceSystem, OfKeysStaysOneOfKeys) {
  constexpr std::uint16_t kNames = 34737, kUnknown = 7;
  const std::string keys = projected(9002), numbers(24, '\1');
  LasFile file = las_file(4, 6, 30, 3);
  file.records = las_record(kProjection, kDirectory, keys) + las_record(kProjection, kDoubles, numbers) +
                 las_record(kProjection, kNames, "a|b|") + las_record(kProjection, kUnknown, "x");
  file.record_count = 4;
  const LabeledCloud cloud = read_las(file.bytes(), {.keep_everything = true});
  const EncodedFile again = written(cloud);
  EXPECT_FALSE(says_that_it_is_text(again.bytes));
  const LabeledCloud reread = read_las(again.bytes, {.keep_everything = true});
  EXPECT_THAT(records_of(reread), ElementsAre(std::pair(kDirectory, keys), std::pair(kDoubles, numbers),
                                              std::pair(kNames, std::string("a|b|"))));
  EXPECT_EQ(reread.placement.meters_per_unit(), cloud.placement.meters_per_unit());
}

TEST(ReferenceSystem, AGivenUnitWinsInTheFileThatIsWrittenToo) {
  const std::string geographic = directory({{1024, 0, 1, 2}});
  for (const std::string& keys : {projected(9002), geographic}) {
    for (const LengthUnit unit : {LengthUnit::kMeter, LengthUnit::kMillimeter}) {
      const EncodedFile again =
          written(read_las(with_record(kDirectory, keys), {.unit = unit, .keep_everything = true}));
      EXPECT_EQ(read_las(again.bytes).placement.meters_per_unit(), meters_per_unit(unit));
    }
  }
}

TEST(ReferenceSystem, BeyondARecordsLengthIsMentioned) {
  const std::string longer = projected_text("\"foot\",0.3048") + std::string(70'000, ' ');
  const EncodedFile again = written(read_las(with_extended_record(kText, longer), {.keep_everything = true}));
  ASSERT_EQ(again.warnings.size(), 1);
  EXPECT_THAT(again.warnings[0].message, HasSubstr("record 2112 of the coordinate reference system is not kept"));
}

}  // namespace
}  // namespace segserve::codec
