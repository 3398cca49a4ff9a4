// SPDX-License-Identifier: Apache-2.0
// Malformed LAS files. Each is refused with a message that names the fault, or read with a warning, and none does harm.

#include <atomic>
#include <limits>

#include "core/codec/las/las.hpp"
#include "test/core/codec/support/damaged_bytes.hpp"
#include "test/core/codec/support/las_file.hpp"
#include "test/core/codec/support/sample_cloud.hpp"

namespace segserve::codec {
namespace {

using testing::HasSubstr;

/// A file with every kind of content.
std::string rich_file() {
  const std::string descriptions = las_extra("segment", 5) + las_extra("height", 4, 8 | 16) + las_extra("raw", 0, 3);
  LasFile file = las_file(4, 7, 36 + 4 + 2 + 3, 5);
  file.records = las_record("LASF_Spec", 4, descriptions) + las_record("segserve", 1, "segserve view camera");
  file.records += las_record("LASF_Projection", 2112, "PROJCS[\"a\",UNIT[\"m\",1]]") +
                  las_record("LASF_Projection", 34735, std::string("\1\0\1\0\0\0\1\0\0\4\0\0\1\0\1\0", 16));
  file.record_count = 4;
  for (char& c : file.body) c = static_cast<char>(c + 1);
  return file.bytes();
}

absl::StatusOr<Cloud> decode_damaged(const std::string& bytes) {
  auto cloud = decode_las(bytes_of(bytes), kDamageLimits, {.keep_everything = true});
  if (!cloud.ok()) return cloud.status();
  return cloud->cloud;
}

template <typename T>
std::string with(std::size_t offset, T value) {
  std::string bytes = las_file(2, 0, 20, 2).bytes();
  put(bytes, offset, value);
  return bytes;
}

TEST(LasMalformed, EachFaultIsNamed) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const std::vector<std::pair<std::string, std::string>> cases{
      {with<std::uint8_t>(24, 2), "version 2.2 is not known; 1.0 to 1.4 are"},
      {with<std::uint8_t>(25, 5), "version 1.5 is not known"},
      {with<std::uint8_t>(104, 11), "point format 11 is not known; 0 to 10 are"},
      {with<std::uint8_t>(104, 128), "this is LAZ"},
      {with<std::uint8_t>(104, 64), "this is LAZ"},
      {with<std::uint8_t>(104, 1), "points of format 1 have at least 28 bytes, not 20"},
      {with<std::uint16_t>(105, 0), "points of format 0 have at least 20 bytes, not 0"},
      {with<std::uint16_t>(94, 100), "its length is 100 bytes"},
      {with<std::uint16_t>(94, 300), "its length is 300 bytes, and the points begin at byte 227"},
      {with<std::uint32_t>(96, 4000), "the points begin at byte 4000, but the file has 267 bytes"},
      {with(131, 0.0), "the scale of x is 0"},
      {with(139, nan), "the scale of y is nan"},
      {with(171, nan), "the offset of z is nan"},
      {std::string("LASF"), "it has 4 bytes and needs 227"},
  };
  for (const auto& [bytes, words] : cases) expect_fault(decode_las(bytes_of(bytes), {}).status(), words);
}

TEST(LasMalformed, LimitsHold) {
  const std::string bytes = las_file(2, 0, 20, 10).bytes();
  expect_over_limit(decode_las(bytes_of(bytes), {.max_points = 9}).status(), "max_points",
                    "10 points exceed the limit of 9");
  expect_over_limit(decode_las(bytes_of(bytes), {.max_bytes = 100}).status(), "max_bytes", "exceed the limit of 100");
  expect_over_limit(decode_las(bytes_of(with<std::uint32_t>(107, 4'000'000'000)), {}).status(), "max_points",
                    "4000000000 points");
}

TEST(LasMalformed, AFileThatIsCutOffGivesItsWholePoints) {
  const std::string bytes = las_file(2, 0, 20, 3).bytes();
  const auto cloud = decode_las(bytes_of(bytes).first(bytes.size() - 1), {});
  ASSERT_TRUE(cloud.ok()) << cloud.status();
  EXPECT_EQ(cloud->cloud.size(), 2U);
  ASSERT_EQ(cloud->warnings.size(), 1U);
  EXPECT_EQ(cloud->warnings[0].reason, WarningReason::kRowsNotUsed);
  EXPECT_THAT(cloud->warnings[0].message, HasSubstr("it holds 2 of 3 points"));
  expect_fault(decode_las(bytes_of(bytes).first(227), {}).status(), "3 points are promised, but the file holds none");
}

TEST(LasMalformed, PointsThatTheHeaderDoesNotPromiseAreMentioned) {
  LasFile file = las_file(2, 0, 20, 5);
  file.points = 3;
  const auto more = decode_las(bytes_of(file.bytes()), {});
  ASSERT_TRUE(more.ok()) << more.status();
  EXPECT_EQ(more->cloud.size(), 3U);
  EXPECT_THAT(more->warnings.at(0).message, HasSubstr("40 bytes, which are 2 rows, are more than the header promises"));

  file.points = 0;
  const auto unclosed = decode_las(bytes_of(file.bytes()), {});
  ASSERT_TRUE(unclosed.ok()) << unclosed.status();
  EXPECT_EQ(unclosed->cloud.size(), 5U);
  EXPECT_THAT(unclosed->warnings.at(0).message, HasSubstr("promises no points, and the file holds 5"));
  expect_over_limit(decode_las(bytes_of(file.bytes()), {.max_points = 4}).status(), "max_points", "exceed the limit");
}

TEST(LasMalformed, ExtendedRecordsAndWaveformsAreNoPoints) {
  for (const std::uint32_t points : {0U, 2U}) {
    for (const unsigned minor : {3U, 4U}) {
      std::string bytes = las_file(minor, minor == 3 ? 4U : 6U, 60, points).bytes();
      if (minor == 3) put(bytes, 227, std::uint64_t{bytes.size()});
      if (minor == 4) put(bytes, 235, std::uint64_t{bytes.size()});
      if (minor == 4) put(bytes, 243, std::uint32_t{1});
      const auto cloud = decode_las(bytes_of(bytes + las_extended_record("other", 1, std::string(540, 'e'))), {});
      ASSERT_TRUE(cloud.ok()) << cloud.status();
      EXPECT_EQ(cloud->cloud.size(), points);
      for (const Warning& warning : cloud->warnings) EXPECT_NE(warning.reason, WarningReason::kRowsNotUsed);
    }
  }
}

TEST(LasMalformed, RecordsThatDoNotFitAreMentioned) {
  const auto cloud = decode_las(bytes_of(with<std::uint32_t>(100, 1'000'000'000)), {});
  ASSERT_TRUE(cloud.ok()) << cloud.status();
  EXPECT_THAT(cloud->warnings.at(0).message, HasSubstr("only 0 of 1000000000 variable length records fit"));
  LasFile wide = las_file(2, 0, 20, 1);
  wide.records = las_record("LASF_Spec", 4, las_extra("wide", 10));
  wide.record_count = 1;
  EXPECT_THAT(decode_las(bytes_of(wide.bytes()), {})->warnings.at(0).message, HasSubstr("'wide' do not fit"));
}

TEST(LasMalformed, ExtendedRecordsThatDoNotFitAreMentioned) {
  const std::string file = las_file(4, 6, 30, 2).bytes();
  std::string long_one = las_extended_record("LASF_Projection", 2112, "PROJCS[]");
  put(long_one, 20, std::numeric_limits<std::uint64_t>::max() - 8);
  for (const std::string& records : {std::string(), std::string(59, ' '), long_one}) {
    for (const std::uint64_t offset : {std::uint64_t{file.size()}, std::numeric_limits<std::uint64_t>::max()}) {
      std::string bytes = file + records;
      put(bytes, 235, offset);
      put(bytes, 243, std::numeric_limits<std::uint32_t>::max());
      const auto cloud = decode_las(bytes_of(bytes), {});
      ASSERT_TRUE(cloud.ok()) << cloud.status();
      EXPECT_EQ(cloud->cloud.size(), 2U);
      EXPECT_THAT(cloud->warnings.back().message,
                  HasSubstr("only 0 of 4294967295 extended variable length records fit in the file"));
    }
  }
}

TEST(LasMalformed, TruncationsAndFlipsDoNoHarm) {
  const std::string bytes = rich_file();
  for (std::size_t size = 0; size < bytes.size(); ++size) {
    ASSERT_NO_FATAL_FAILURE(expect_sound(decode_damaged(std::string(bytes.data(), size)))) << size;
  }
  expect_flips_survived(bytes, decode_damaged);
}

TEST(LasMalformed, AStopIsHeard) {
  const std::string bytes = las_file(2, 0, 20, 200'000).bytes();
  const std::atomic<bool> cancelled = true;
  WorkMeter meter;
  const StopToken stop(&cancelled, std::nullopt, &meter);
  EXPECT_EQ(decode_las(bytes_of(bytes), {}, {.keep_everything = true}, stop).status().code(),
            absl::StatusCode::kCancelled);
  EXPECT_LE(meter.units(), StopToken::kMostWorkAfterStop);
}

}  // namespace
}  // namespace segserve::codec
