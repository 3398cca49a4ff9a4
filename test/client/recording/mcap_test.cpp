// SPDX-License-Identifier: Apache-2.0
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>

#include "client/recording/bytes/append.hpp"
#include "client/recording/mcap/mcap_records.hpp"
#include "test/client/recording/recording_files.hpp"

namespace segserve::recording {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

constexpr std::uint64_t kTime = 1'700'000'000'000'000'000;

/// Two topics, ten messages, some metadata.
std::string small_file() {
  return mcap_with([](McapWriter& writer) {
    EXPECT_TRUE(writer.define(1, cloud_schema()).ok());
    EXPECT_TRUE(writer.define(3, Channel{1, "/points", "cdr", {{"offered_qos_profiles", "- a"}}}).ok());
    EXPECT_TRUE(writer.define(4, Channel{0, "/text", "json", {}}).ok());
    for (std::uint32_t i = 0; i < 10; ++i) {
      const std::string data = "message " + std::to_string(i);
      const auto channel = static_cast<std::uint16_t>(i % 2 == 0 ? 3 : 4);
      EXPECT_TRUE(writer.write(Message{channel, i, kTime + i, kTime + 100 + i, data}).ok());
    }
    std::string metadata;
    append_counted(metadata, "rosbag2");
    append_counted(metadata, "");
    EXPECT_TRUE(writer.write(Extra{kMetadata, metadata}).ok());
  });
}

TEST(Mcap, WhatIsWrittenIsRead) {
  const Content content = read_all(small_file());
  EXPECT_TRUE(content.status.ok()) << content.status;
  EXPECT_THAT(content.warnings, IsEmpty());
  ASSERT_EQ(content.messages.size(), 10U);
  for (std::uint32_t i = 0; i < 10; ++i) {
    EXPECT_EQ(content.messages[i].channel, i % 2 == 0 ? 3 : 4);
    EXPECT_EQ(content.messages[i].sequence, i);
    EXPECT_EQ(content.messages[i].log_time, kTime + i);
    EXPECT_EQ(content.messages[i].publish_time, kTime + 100 + i);
    EXPECT_EQ(content.data[i], "message " + std::to_string(i));
  }
  EXPECT_THAT(content.extras, ElementsAre(kMetadata));
  const Channel& channel = content.definitions.channels.at(3);
  EXPECT_EQ(channel.topic, "/points");
  EXPECT_EQ(channel.message_encoding, "cdr");
  EXPECT_EQ(channel.metadata.at("offered_qos_profiles"), "- a");
  EXPECT_EQ(content.definitions.schema_of(channel).name, "sensor_msgs/msg/PointCloud2");
  EXPECT_EQ(content.definitions.schema_of(content.definitions.channels.at(4)).name, "");
}

TEST(Mcap, TheSummaryTellsTheContents) {
  const TemporaryFile file(small_file());
  const auto source = open_source(file.path(), {});
  ASSERT_TRUE(source.ok());
  const auto contents = (*source)->indexed_contents();
  ASSERT_TRUE(contents.ok() && *contents);
  EXPECT_THAT((*contents)->messages, ElementsAre(std::pair(3, 5), std::pair(4, 5)));
  EXPECT_EQ((*contents)->definitions.channels.at(4).topic, "/text");
  EXPECT_EQ((*contents)->definitions.schemas.at(1).encoding, "ros2msg");
  EXPECT_EQ((*source)->profile(), "ros2");
  EXPECT_TRUE(*(*source)->next({})) << "reading begins at the beginning all the same";
}

TEST(Mcap, ADamagedSummaryIsNotBelieved) {
  std::string bytes = small_file();
  bytes[bytes.size() - 60] ^= 1;
  const TemporaryFile file(bytes);
  EXPECT_FALSE((*(*open_source(file.path(), {}))->indexed_contents()));
  const auto contents = read_contents(file.path(), {}, {});
  ASSERT_TRUE(contents.ok());
  EXPECT_THAT(contents->messages, ElementsAre(std::pair(3, 5), std::pair(4, 5))) << "they are counted instead";
}

TEST(Mcap, ManyChunksAreReadInTheirOrder) {
  const std::string large(std::size_t{1} << 20U, 'x');
  const std::string bytes = mcap_with([&](McapWriter& writer) {
    EXPECT_TRUE(writer.define(1, Channel{0, "/a", "json", {}}).ok());
    for (std::uint32_t i = 0; i < 20; ++i) EXPECT_TRUE(writer.write(Message{1, i, i, i, large}).ok());
  });
  EXPECT_LT(bytes.size(), large.size()) << "zstd";
  const Content content = read_all(bytes);
  ASSERT_EQ(content.messages.size(), 20U);
  for (std::uint32_t i = 0; i < 20; ++i) EXPECT_EQ(content.messages[i].sequence, i);
  EXPECT_EQ(content.data[19], large);
}

TEST(Mcap, AnEmptyRecordingIsWhole) {
  const Content content = read_all(mcap_with([](McapWriter&) {}));
  EXPECT_TRUE(content.status.ok());
  EXPECT_THAT(content.messages, IsEmpty());
  EXPECT_THAT(content.warnings, IsEmpty());
}

TEST(Mcap, AFileThatIsCutOffAnywhereIsReadUpToThere) {
  const std::string whole = small_file();
  for (std::size_t size = kMcapMagic.size(); size < whole.size(); ++size) {
    const Content content = read_all(whole.substr(0, size));
    ASSERT_TRUE(content.status.ok()) << size << ": " << content.status;
    for (std::size_t i = 0; i < content.messages.size(); ++i) {
      ASSERT_EQ(content.data[i], "message " + std::to_string(i)) << size;
    }
    ASSERT_TRUE(content.messages.size() == 10U || !content.warnings.empty()) << size;
  }
}

/// A file of a header and the given records, without an end.
std::string file_of(const std::string& records) {
  std::string file(kMcapMagic);
  append_record(file, kHeader, std::string(8, '\0'));
  return file + records;
}

std::string chunk_record(std::string_view compression, std::string_view records, std::uint64_t claimed,
                         std::uint32_t crc) {
  std::string content(16, '\0');
  append_number(content, claimed);
  append_number(content, crc);
  append_counted(content, compression);
  append_counted<std::uint64_t>(content, records);
  std::string record;
  append_record(record, kChunk, content);
  return record;
}

std::string one_message() {
  std::string records;
  append_channel(records, 7, Channel{0, "/a", "json", {}});
  append_message(records, Message{7, 1, 2, 3, "{}"});
  return records;
}

TEST(Mcap, MessagesWithoutChunksAreRead) {
  const Content content = read_all(file_of(one_message()));
  EXPECT_THAT(content.data, ElementsAre("{}"));
  ASSERT_EQ(content.warnings.size(), 1U);
  EXPECT_THAT(content.warnings[0].message, HasSubstr("without a footer, as after a crash"));
}

TEST(Mcap, AMessageIsReadFromAChunkThatIsCutOff) {
  const std::string records = one_message();
  std::string file = file_of(chunk_record("", records + records, 2 * records.size(), 0));
  file.resize(file.size() - 3);
  const Content content = read_all(file);
  EXPECT_THAT(content.data, ElementsAre("{}"));
  EXPECT_THAT(content.warnings[0].message, HasSubstr("the file ends within the record at byte 25"));
}

TEST(Mcap, AChunkWithAWrongCrcIsLeftOutByName) {
  const std::string records = one_message();
  const Content content = read_all(file_of(chunk_record("", records, records.size(), 5) + records));
  EXPECT_THAT(content.data, ElementsAre("{}")) << "what follows is read";
  EXPECT_THAT(content.warnings[0].message, HasSubstr("the chunk at byte 25 is damaged (CRC "));
}

TEST(Mcap, ClaimsAreComparedWithLimitsAndBytes) {
  const std::string records = one_message();
  const codec::DecodeLimits limits{.max_bytes = 10'000};
  const Content large = read_all(file_of(chunk_record("zstd", records, 10'001, 0)), limits);
  EXPECT_EQ(large.status.code(), absl::StatusCode::kInvalidArgument);
  EXPECT_THAT(std::string(large.status.message()), HasSubstr("has 10001 bytes, above the limit of 10000"));
  for (const char* compression : {"", "lz4", "zstd"}) {
    const Content damaged = read_all(file_of(chunk_record(compression, records, records.size() + 1, 0)), limits);
    EXPECT_TRUE(damaged.status.ok());
    EXPECT_THAT(damaged.data, IsEmpty());
    EXPECT_THAT(damaged.warnings[0].message, HasSubstr("does not decompress to the"));
  }
}

TEST(Mcap, AnUnknownCompressionIsNamed) {
  const Content content = read_all(file_of(chunk_record("brotli", "", 0, 0)));
  EXPECT_EQ(content.status.code(), absl::StatusCode::kInvalidArgument);
  EXPECT_THAT(std::string(content.status.message()), HasSubstr("'brotli', which is not known: lz4, zstd"));
}

TEST(Mcap, OtherFilesAreNamed) {
  using std::string_view_literals::operator""sv;
  EXPECT_THAT(std::string(read_all("SQLite format 3\0 and more"sv).status.message()), HasSubstr("ros2 bag convert"));
  EXPECT_THAT(std::string(read_all("").status.message()), HasSubstr("the file is empty"));
  EXPECT_THAT(std::string(read_all("VERSION 0.7").status.message()), HasSubstr("neither an MCAP file nor a ROS bag"));
}

TEST(Mcap, AFlippedBitAnywhereEndsInWordsOrInTheSameMessages) {
  const std::string whole = small_file();
  for (std::size_t at = 0; at < whole.size(); ++at) {
    std::string damaged = whole;
    damaged[at] = static_cast<char>(damaged[at] ^ 0x11);
    const Content content = read_all(damaged, {.max_bytes = 1 << 20});
    for (const std::string& data : content.data) ASSERT_THAT(data, testing::StartsWith("message ")) << at;
  }
}

TEST(Mcap, StopIsHeard) {
  const TemporaryFile file(small_file());
  const std::atomic<bool> stop{true};
  EXPECT_EQ((*open_source(file.path(), {}))->next(StopToken(&stop)).status().code(), absl::StatusCode::kCancelled);
}

}  // namespace
}  // namespace segserve::recording
