// SPDX-License-Identifier: Apache-2.0
#include "proto/wire/byte_run.hpp"

#include <array>
#include <random>

#include "gtest/gtest.h"

namespace segserve::wire {
namespace {

TEST(Crc32, IsTheOneOfZlibAndPng) {
  EXPECT_EQ(crc32(0, ""), 0U);
  EXPECT_EQ(crc32(0, "123456789"), 0xCBF43926U);  // This is the check value of the catalog of CRCs.
  EXPECT_EQ(crc32(crc32(0, "1234"), "56789"), 0xCBF43926U);
}

TEST(ByteRun, TakesTheBlocks) {
  std::string a = "abcde", b, c = "fg";
  const ByteRun run(std::array<std::string*, 3>{&a, &b, &c});
  EXPECT_TRUE(a.empty() && c.empty());
  EXPECT_EQ(run.size(), 7U);
  EXPECT_EQ(run.crc32(), crc32(0, "abcdefg"));
}

TEST(ByteRun, LeavesSharedBytesWhereTheyAre) {
  const auto owner = std::make_shared<const std::string>("abcdefg");
  const ByteRun run({std::string_view(*owner).substr(0, 5), std::string_view(*owner).substr(5)}, owner);
  EXPECT_EQ(run.blocks()[0].data(), owner->data());
  EXPECT_EQ(run.size(), 7U);
  EXPECT_EQ(run.crc32(), crc32(0, "abcdefg"));
  EXPECT_EQ(owner.use_count(), 2);
}

TEST(OutgoingBytes, CutARunInOrderAsOftenAsWanted) {
  std::string a, b = "abcde", c, d = "fg";
  const auto run = std::make_shared<const ByteRun>(std::array<std::string*, 4>{&a, &b, &c, &d});
  for (int round = 0; round < 2; ++round) {
    OutgoingBytes out(run);
    EXPECT_EQ(out.next(3), "abc");
    EXPECT_EQ(out.next(3), "de");
    EXPECT_FALSE(out.done());
    EXPECT_EQ(out.next(3), "fg");
    EXPECT_TRUE(out.done());
    EXPECT_TRUE(out.next(3).empty());
  }
}

TEST(OutgoingBytes, OfNothingAreDone) {
  EXPECT_TRUE(OutgoingBytes().done());
  std::string empty;
  EXPECT_TRUE(OutgoingBytes(std::make_shared<const ByteRun>(std::array<std::string*, 1>{&empty})).done());
}

TEST(IncomingBytes, PutsTheRunTogetherHoweverItIsCut) {
  std::mt19937 random(1);
  for (int round = 0; round < 100; ++round) {
    std::vector<std::string> sent(1 + random() % 4);
    std::vector<std::uint64_t> sizes;
    std::vector<std::string*> from;
    for (std::string& block : sent) {
      block.resize(random() % 50);
      for (char& byte : block) byte = static_cast<char>(random());
      sizes.push_back(block.size());
      from.push_back(&block);
    }
    const std::vector<std::string> copies = sent;
    const auto promised = std::make_shared<const ByteRun>(from);
    OutgoingBytes out(promised);
    std::string run;
    while (!out.done()) run += out.next(1 + random() % 20);

    IncomingBytes in(sizes);
    for (std::string_view rest = run; !rest.empty();) {
      const std::string_view chunk = rest.substr(0, 1 + random() % 30);
      ASSERT_TRUE(in.add(chunk));
      rest.remove_prefix(chunk.size());
      ASSERT_EQ(in.missing(), rest.size());
    }
    EXPECT_EQ(in.crc32(), promised->crc32());
    in.move_to(from);
    EXPECT_EQ(sent, copies);
  }
}

TEST(IncomingBytes, RefusesMoreThanWasPromised) {
  IncomingBytes in({2, 3});
  EXPECT_TRUE(in.add("abc"));
  EXPECT_FALSE(in.add("def"));
  EXPECT_EQ(in.missing(), 2U);
  EXPECT_TRUE(in.add("de"));
  EXPECT_FALSE(in.add("f"));
}

TEST(IncomingBytes, AcceptsAbsurdPromisesWithoutTheirMemory) {
  IncomingBytes in({std::uint64_t{1} << 60U});
  EXPECT_TRUE(in.add("a"));
  EXPECT_EQ(IncomingBytes({UINT64_MAX, 2}).missing(), UINT64_MAX) << "the sum of the sizes overflows";
}

}  // namespace
}  // namespace segserve::wire
