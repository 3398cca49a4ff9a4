// SPDX-License-Identifier: Apache-2.0
#include <bzlib.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <lz4frame.h>

#include <map>
#include <string>

#include "client/recording/bytes/append.hpp"
#include "client/recording/rosbag1/bag_records.hpp"
#include "test/client/recording/recording_files.hpp"

namespace segserve::recording {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

template <std::integral T>
std::string number(T value) {
  std::string bytes;
  append_number(bytes, value);
  return bytes;
}

std::string fields(const std::map<std::string, std::string>& all) {
  std::string bytes;
  for (const auto& [name, value] : all) append_counted(bytes, name + "=" + value);
  return bytes;
}

std::string record(const std::map<std::string, std::string>& header, const std::string& data) {
  std::string bytes;
  append_counted(bytes, fields(header));
  append_counted(bytes, data);
  return bytes;
}

std::string connection(std::uint32_t number_of_it) {
  return record(
      {{"op", "\7"}, {"conn", number(number_of_it)}, {"topic", "/points"}},
      fields({{"type", "sensor_msgs/PointCloud2"}, {"md5sum", "abc"}, {"message_definition", "Header header"}}));
}

std::string message(std::uint32_t connection_number, std::uint32_t seconds, const std::string& data) {
  return record({{"op", "\2"}, {"conn", number(connection_number)}, {"time", number(seconds) + number(5U)}}, data);
}

std::string compressed(const std::string& compression, std::string bytes) {
  if (compression == "bz2") {
    std::string out(bytes.size() + 1000, '\0');
    auto size = static_cast<unsigned>(out.size());
    EXPECT_EQ(BZ2_bzBuffToBuffCompress(out.data(), &size, bytes.data(), static_cast<unsigned>(bytes.size()), 9, 0, 0),
              BZ_OK);
    return out.substr(0, size);
  }
  if (compression == "lz4") {
    std::string out(LZ4F_compressFrameBound(bytes.size(), nullptr), '\0');
    out.resize(LZ4F_compressFrame(out.data(), out.size(), bytes.data(), bytes.size(), nullptr));
    return out;
  }
  return bytes;
}

/// A bag of one chunk with two messages, and its index.
std::string bag(const std::string& compression) {
  const std::string records = connection(0) + message(0, 1, "first") + message(0, 2, "second");
  const std::string chunk =
      record({{"op", "\5"}, {"compression", compression}, {"size", number(static_cast<std::uint32_t>(records.size()))}},
             compressed(compression, records));
  const std::string index = record({{"op", "\4"}, {"conn", number(0U)}}, std::string(24, '\0'));
  const auto header = [](std::uint64_t index_at) {
    const std::string zeros(4, '\0');
    return record({{"op", "\3"}, {"index_pos", number(index_at)}, {"conn_count", zeros}, {"chunk_count", zeros}},
                  std::string(100, ' '));
  };
  const std::uint64_t index_at = kBagMagic.size() + header(0).size() + chunk.size() + index.size();
  return std::string(kBagMagic) + header(index_at) + chunk + index + connection(0) +
         record({{"op", "\6"}}, number(0U) + number(2U));
}

TEST(Bag, MessagesAreReadFromEachKindOfChunk) {
  for (const char* compression : {"none", "bz2", "lz4"}) {
    const Content content = read_all(bag(compression));
    EXPECT_TRUE(content.status.ok()) << content.status;
    EXPECT_THAT(content.warnings, IsEmpty()) << compression;
    EXPECT_THAT(content.data, ElementsAre("first", "second")) << compression;
    EXPECT_EQ(content.messages[1].log_time, 2'000'000'005U);
    EXPECT_EQ(content.messages[1].sequence, 1U);
    const Channel& channel = content.definitions.channels.at(1);
    EXPECT_EQ(channel.topic, "/points");
    EXPECT_EQ(channel.message_encoding, "ros1");
    EXPECT_EQ(channel.metadata.at("md5sum"), "abc");
    EXPECT_EQ(content.definitions.schema_of(channel).name, "sensor_msgs/PointCloud2");
    EXPECT_EQ(content.definitions.schema_of(channel).data, "Header header");
  }
}

TEST(Bag, TheIndexTellsTheContents) {
  const TemporaryFile file(bag("bz2"));
  const auto source = open_source(file.path(), {});
  ASSERT_TRUE(source.ok());
  EXPECT_EQ((*source)->profile(), "ros1");
  const auto contents = (*source)->indexed_contents();
  ASSERT_TRUE(contents.ok() && *contents);
  EXPECT_THAT((*contents)->messages, ElementsAre(std::pair(1, 2)));
  EXPECT_EQ((*contents)->definitions.channels.at(1).topic, "/points");
  EXPECT_TRUE((*(*source)->next({}))->message);
}

TEST(Bag, ABagThatIsCutOffAnywhereIsReadUpToThere) {
  for (const char* compression : {"none", "bz2", "lz4"}) {
    const std::string whole = bag(compression);
    for (std::size_t size = 16; size < whole.size(); ++size) {
      const Content content = read_all(whole.substr(0, size));
      ASSERT_TRUE(content.status.ok()) << size << ": " << content.status;
      ASSERT_TRUE(content.data.size() == 2 || !content.warnings.empty() || size < 200) << size;
    }
  }
}

TEST(Bag, AFlippedBitAnywhereEndsInWordsOrInSomeMessages) {
  const std::string whole = bag("none");
  for (std::size_t at = 16; at < whole.size(); ++at) {
    std::string damaged = whole;
    damaged[at] = static_cast<char>(damaged[at] ^ 0x11);
    EXPECT_LE(read_all(damaged, {.max_bytes = 1 << 20}).messages.size(), 2U) << at;
  }
}

TEST(Bag, ClaimsAreComparedWithLimits) {
  const std::string file =
      std::string(kBagMagic) + record({{"op", "\5"}, {"compression", "lz4"}, {"size", number(10'001U)}}, "some bytes");
  const Content content = read_all(file, {.max_bytes = 10'000});
  EXPECT_THAT(std::string(content.status.message()), HasSubstr("has 10001 bytes, above the limit of 10000"));
}

TEST(Bag, OldVersionsAreNamed) {
  EXPECT_THAT(std::string(read_all("#ROSBAG V1.2\nand so on").status.message()), HasSubstr("rosbag fix"));
}

}  // namespace
}  // namespace segserve::recording
