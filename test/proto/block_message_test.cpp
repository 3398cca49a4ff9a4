// SPDX-License-Identifier: Apache-2.0
#include "proto/wire/block_message.hpp"

#include <random>
#include <string>

#include "gmock/gmock.h"
#include "proto/wire/status_message.hpp"

namespace segserve::wire {
namespace {

using testing::AllOf;
using testing::HasSubstr;

std::string error_of(const v1::Block& block, std::uint64_t expected) {
  std::string buffer;
  const auto bytes = block_bytes(block, expected, "the.block", buffer);
  EXPECT_EQ(details_of(bytes.status()).reason, ErrorReason::kMalformedPayload);
  return std::string(bytes.status().message());
}

TEST(Block, KeepsItsBytesInEveryCompression) {
  const std::string bytes = std::string(1000, 'a') + std::string("\0b", 2);
  for (const auto compression : {v1::COMPRESSION_NONE, v1::COMPRESSION_ZSTD}) {
    const auto block = to_block(bytes, compression);
    ASSERT_TRUE(block.ok());
    EXPECT_EQ(block->compression(), compression);
    EXPECT_EQ(block->decoded_bytes(), bytes.size());
    std::string buffer;
    EXPECT_EQ(block_bytes(*block, bytes.size(), "block", buffer).value(), bytes);
  }
}

TEST(Block, TellsItsEncodedSizeWhichMustBeTrueWhenSet) {
  for (const auto compression : {v1::COMPRESSION_NONE, v1::COMPRESSION_ZSTD}) {
    v1::Block block = to_block(std::string(1000, 'a'), compression).value();
    EXPECT_EQ(block.encoded_bytes(), block.data().size());
    block.set_encoded_bytes(block.data().size() + 1);
    EXPECT_THAT(error_of(block, 1000), AllOf(HasSubstr("the.block"), HasSubstr("encoded bytes")));
  }
}

TEST(Block, OfUnknownSizeIsBoundedByALimit) {
  for (const auto compression : {v1::COMPRESSION_NONE, v1::COMPRESSION_ZSTD}) {
    const v1::Block block = to_block(std::string(1000, 'a'), compression).value();
    std::string buffer;
    EXPECT_EQ(block_bytes_up_to(block, 1000, "file", buffer).value(), std::string(1000, 'a'));
    const absl::Status status = block_bytes_up_to(block, 999, "the.file", buffer).status();
    EXPECT_EQ(details_of(status).reason, ErrorReason::kLimitExceeded);
    EXPECT_THAT(std::string(status.message()), HasSubstr("the.file has 1000 bytes"));
  }
}

TEST(Block, ZstdMakesRepetitionSmall) {
  EXPECT_LT(to_block(std::string(10'000, 'a'), v1::COMPRESSION_ZSTD)->data().size(), 100U);
}

TEST(Block, IsCompressedOnlyIfThatMakesItSmaller) {
  std::mt19937 random(1);
  std::string noise(10'000, '\0');
  for (char& byte : noise) byte = static_cast<char>(random());
  for (const std::string& bytes : {std::string(), std::string("abc"), noise}) {
    const v1::Block block = to_block(bytes, v1::COMPRESSION_ZSTD).value();
    EXPECT_EQ(block.compression(), v1::COMPRESSION_NONE);
    EXPECT_EQ(block.data(), bytes);
    EXPECT_EQ(block.encoded_bytes(), bytes.size());
    EXPECT_EQ(block.decoded_bytes(), bytes.size());
  }
}

TEST(Block, WithoutCompressionNeedNotSayItsSize) {
  v1::Block block;
  block.set_data("abc");
  std::string buffer;
  EXPECT_EQ(block_bytes(block, 3, "block", buffer).value(), "abc");
}

TEST(Block, RefusesASizeThatIsNotExpected) {
  v1::Block block;
  block.set_data("abc");
  EXPECT_THAT(error_of(block, 4), AllOf(HasSubstr("the.block"), HasSubstr("has 3 bytes"), HasSubstr("4")));
  block.set_decoded_bytes(5);
  EXPECT_THAT(error_of(block, 3), HasSubstr("claims 5 bytes"));
}

TEST(Block, RefusesUnknownCompressionByNumber) {
  v1::Block block;
  block.set_compression(static_cast<v1::Compression>(77));
  EXPECT_THAT(error_of(block, 0), HasSubstr("77"));
}

TEST(Block, RefusesDataThatAreNotZstd) {
  v1::Block block;
  block.set_compression(v1::COMPRESSION_ZSTD);
  block.set_decoded_bytes(8);
  block.set_data("no zstd");
  EXPECT_THAT(error_of(block, 8), HasSubstr("the.block"));
}

TEST(Block, RefusesZstdThatLiesAboutItsSize) {
  v1::Block block = to_block(std::string(1000, 'a'), v1::COMPRESSION_ZSTD).value();
  block.set_decoded_bytes(10);
  error_of(block, 10);
  block.set_decoded_bytes(std::uint64_t{1} << 40U);
  EXPECT_THAT(error_of(block, 1000), HasSubstr("claims 1099511627776 bytes"));
}

}  // namespace
}  // namespace segserve::wire
