// SPDX-License-Identifier: Apache-2.0
// Saved results are exact, and decoding anything else is safe.
#include "segserve/client/result_file.hpp"

#include <cstdint>
#include <limits>
#include <string>
#include <string_view>
#include <vector>

#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "proto/wire/result_message.hpp"
#include "segserve/segment.hpp"
#include "test/client/client_scenes.hpp"

namespace segserve::client {
namespace {

using testing::HasSubstr;

Result make_result(const Cloud& cloud) {
  auto segmentation = segment(cloud, {});
  return wire::make_result(*std::move(segmentation), cloud, {}, "because", "1.2.3");
}

std::string saved() {
  static const std::string kBytes = *encode_result_file(make_result(table_scene()), fingerprint(table_scene()));
  return kBytes;
}

/// Decodes what is no saved result; returns the message of the refusal.
std::string refusal(std::string_view bytes) {
  const auto result = decode_result_file(bytes);
  EXPECT_TRUE(absl::IsInvalidArgument(result.status())) << result.status();
  return std::string(result.status().message());
}

TEST(ResultFile, KeepsEverythingThatACutNeeds) {
  const Result before = make_result(table_scene());
  const auto after = decode_result_file(saved());
  ASSERT_TRUE(after.ok()) << after.status();
  EXPECT_EQ(after->segmentation.labels, before.segmentation.labels);
  EXPECT_EQ(after->segmentation.supervoxels, before.segmentation.supervoxels);
  EXPECT_EQ(after->segmentation.tree, before.segmentation.tree);
  EXPECT_EQ(after->method, before.method);
  EXPECT_EQ(after->segmentation.threshold, before.segmentation.threshold);
  EXPECT_EQ(after->view, before.view);
  EXPECT_EQ(after->view_rule, "because");
  EXPECT_EQ(after->server_version, "1.2.3");
}

TEST(ResultFile, KeepsTheStatisticsOfTheSegments) {
  Result before = make_result(table_scene());
  ASSERT_TRUE(describe(table_scene(), 1, {}, before.segmentation).ok());
  const auto after = decode_result_file(encode_result_file(before).value());
  ASSERT_TRUE(after.ok()) << after.status();
  EXPECT_EQ(after->segmentation.statistics, before.segmentation.statistics);
  EXPECT_FALSE(after->segmentation.statistics.empty());
  EXPECT_TRUE(decode_result_file(saved())->segmentation.statistics.empty());
}

TEST(ResultFile, KeepsAResultWithoutAnyFinitePoint) {
  Cloud cloud = flat_cloud(4, 4);
  for (float& z : cloud.z) z = std::numeric_limits<float>::quiet_NaN();
  const auto bytes = encode_result_file(make_result(cloud));
  ASSERT_TRUE(bytes.ok()) << bytes.status();
  const auto after = decode_result_file(*bytes);
  ASSERT_TRUE(after.ok()) << after.status();
  EXPECT_EQ(after->segmentation.labels, std::vector<std::uint32_t>(16, 0));
}

TEST(ResultFile, BeginsWithTheDocumentedLine) {
  const std::string bytes = saved();
  const std::size_t end = bytes.find('\n');
  ASSERT_NE(end, std::string::npos);
  const std::string size = std::to_string(bytes.size() - end - 1);
  EXPECT_THAT(bytes.substr(0, end), testing::MatchesRegex("segserve-result 3 " + size + "( [0-9a-f]{8}){3}"));
}

TEST(ResultFile, RefusesForeignFiles) {
  for (const std::string& foreign : {std::string(), std::string("# .PCD v0.7\nVERSION 0.7\n"), std::string(1000, '\0'),
                                     std::string("segserve-resul")}) {
    EXPECT_THAT(refusal(foreign), HasSubstr("not a result that segctl saved"));
  }
}

TEST(ResultFile, RefusesOtherVersions) {
  std::string bytes = saved();
  bytes.replace(bytes.find(" 3 "), 3, " 1 ");
  EXPECT_THAT(refusal(bytes), HasSubstr("version '1'"));
}

TEST(ResultFile, TellsTheCloudThatWasSegmented) {
  const auto print = fingerprint_in_result_file(saved());
  ASSERT_TRUE(print.ok()) << print.status();
  EXPECT_EQ(*print, fingerprint(table_scene()));
  EXPECT_TRUE(absl::IsInvalidArgument(fingerprint_in_result_file("segserve-result 3 0 00000000 0\n").status()));
}

TEST(ResultFile, ReadsVersion2WhichTellsNoCloud) {
  const std::string bytes = encode_result_file(make_result(table_scene())).value();
  EXPECT_THAT(bytes, testing::StartsWith("segserve-result 2 "));
  EXPECT_EQ(fingerprint_in_result_file(bytes).value(), std::nullopt);
  const auto result = decode_result_file(bytes);
  ASSERT_TRUE(result.ok()) << result.status();
  EXPECT_EQ(result->segmentation.labels, decode_result_file(saved())->segmentation.labels);
}

TEST(ResultFile, RefusesEveryTruncation) {
  const std::string bytes = saved();
  for (std::size_t size = 0; size < bytes.size(); size += size < 100 ? 1 : 97) refusal(bytes.substr(0, size));
  EXPECT_THAT(refusal(bytes.substr(0, bytes.size() - 1)), HasSubstr("truncated"));
  EXPECT_THAT(refusal(bytes + "x"), HasSubstr("too long"));
}

TEST(ResultFile, RefusesEveryFlippedByte) {
  const std::string bytes = saved();
  for (std::size_t i = 0; i < bytes.size(); i += i < 100 ? 1 : 101) {
    std::string damaged = bytes;
    damaged[i] = static_cast<char>(damaged[i] ^ 0x10);
    refusal(damaged);
  }
}

TEST(ResultFile, RefusesHeadersThatLie) {
  refusal("segserve-result 2 99999999999999999999999999 00000000\nabc");
  refusal("segserve-result 2 -1 00000000\nabc");
  refusal("segserve-result 2 3 zz\nabc");
  refusal("segserve-result 2 3\nabc");
  refusal("segserve-result 2 0 00000000 more\n");
  refusal("segserve-result 3 0 00000000\n");
  refusal("segserve-result 3 0 00000000 12345678\n");
  refusal("segserve-result 3 0 00000000 12345678 123456789\n");
  refusal("segserve-result 3 0 00000000 12345678 12345678 more\n");
  EXPECT_THAT(refusal("segserve-result 2 0 00000000\n"),
              HasSubstr("damaged"));  // the header is well formed, but there is no result
}

}  // namespace
}  // namespace segserve::client
