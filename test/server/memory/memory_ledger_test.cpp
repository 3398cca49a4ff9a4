// SPDX-License-Identifier: Apache-2.0
#include "server/memory/memory_ledger.hpp"

#include <chrono>
#include <limits>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "gtest/gtest.h"

namespace segserve::server {
namespace {

using std::chrono::seconds;

const MemoryOwner kMe{"here", "1"}, kOther{"elsewhere", "2"};

TEST(MemoryLedger, NeverLeasesMoreThanItsBudget) {
  MemoryLedger ledger(100);
  auto first = ledger.lease(kMe, 60);
  ASSERT_TRUE(first && first->resize(60));
  EXPECT_FALSE(ledger.lease(kMe, 41));
  EXPECT_FALSE(ledger.lease(kMe, std::numeric_limits<std::uint64_t>::max()));
  const auto second = ledger.lease(kMe, 40);
  EXPECT_TRUE(second);
  EXPECT_EQ(ledger.leased(), 100U);
  EXPECT_FALSE(ledger.lease(kMe, 1));
  EXPECT_TRUE(ledger.lease(kMe, 0));
}

TEST(MemoryLedger, ALeaseGrowsIfThereIsRoomAndAlwaysShrinks) {
  MemoryLedger ledger(100);
  MemoryLease lease = *ledger.lease(kMe, 60);
  EXPECT_TRUE(lease.resize(60));
  const auto other = ledger.lease(kOther, 30);
  EXPECT_FALSE(lease.resize(71));
  EXPECT_EQ(lease.bytes(), 60U);
  EXPECT_TRUE(lease.resize(70));
  EXPECT_EQ(ledger.leased(), 100U);
  EXPECT_TRUE(lease.resize(5));
  EXPECT_EQ(ledger.leased(), 35U);
}

TEST(MemoryLedger, ALeaseMovesAndEndsOnce) {
  MemoryLedger ledger(100);
  {
    auto first = ledger.lease(kMe, 10);
    MemoryLease moved = *std::move(first);
    MemoryLease other = *ledger.lease(kOther, 20);
    EXPECT_EQ(ledger.leased(), 30U);
    other = std::move(moved);
    EXPECT_EQ(ledger.leased(), 10U) << "the 20 are back";
    other.release();
    other.release();
    EXPECT_EQ(ledger.leased(), 0U);
    EXPECT_FALSE(other.resize(1)) << "it belongs to no ledger any more";
  }
  EXPECT_EQ(ledger.leased(), 0U);
}

TEST(MemoryLedger, WhatOnlyWaitsLeavesRoomForWhatIsComputed) {
  MemoryLedger ledger(100);
  auto first = ledger.lease(kMe, 40);
  EXPECT_FALSE(ledger.lease(kMe, 20));
  const auto second = ledger.lease(kMe, 10);
  EXPECT_TRUE(second);
  EXPECT_TRUE(first->resize(90)) << "its turn has come";
  first->release();
  EXPECT_TRUE(ledger.lease(kMe, 40)) << "10 wait still";
}

TEST(MemoryLedger, OneThingMayWaitHoweverLargeItIs) {
  MemoryLedger ledger(100);
  EXPECT_TRUE(ledger.lease(kMe, 80));
}

/// Both the address and the stream of the other may differ, or the stream only.
class MemoryLedgerShares : public testing::TestWithParam<MemoryOwner> {};

INSTANTIATE_TEST_SUITE_P(Others, MemoryLedgerShares,
                         testing::Values(kOther, MemoryOwner{kMe.address, "another stream"}));

TEST_P(MemoryLedgerShares, WhileOthersAreRefusedNobodyGetsMoreThanAShare) {
  const MemoryOwner other = GetParam();
  MemoryLedger::Time now{};
  now += seconds(100);
  MemoryLedger ledger(100, [&now] { return now; });
  std::vector<MemoryLease> mine;
  const auto take = [&](std::uint64_t bytes) {
    auto lease = ledger.lease(kMe, bytes);
    if (!lease) return false;
    lease->resize(bytes);
    mine.push_back(*std::move(lease));
    return true;
  };
  for (int i = 0; i < 9; ++i) EXPECT_TRUE(take(10)) << "nobody else wants any";
  EXPECT_FALSE(ledger.is_short());
  EXPECT_FALSE(ledger.lease(other, 20));
  EXPECT_TRUE(ledger.is_short());
  mine.resize(6);
  EXPECT_FALSE(take(10)) << "it has more than half of the budget, and another client waits";
  const auto theirs = ledger.lease(other, 20);
  EXPECT_TRUE(theirs);
  mine.resize(3);
  EXPECT_TRUE(take(10)) << "this is within its half";
  EXPECT_TRUE(take(10));
  EXPECT_FALSE(take(10));
  now += seconds(6);
  EXPECT_FALSE(ledger.is_short());
  EXPECT_TRUE(take(10)) << "the other client has what it wanted";
}

TEST(MemoryLedger, ACrowdThatWasRefusedGetsWhatBecomesFree) {
  MemoryLedger ledger(100);
  auto all = ledger.lease(kMe, 100);
  for (int i = 0; i < 50; ++i) EXPECT_FALSE(ledger.lease({"crowded", std::to_string(i)}, 30));
  for (int i = 0; i < 50; ++i) EXPECT_FALSE(ledger.lease({std::to_string(i), "alone"}, 30));
  all->release();
  auto first = ledger.lease({"crowded", "7"}, 30);
  ASSERT_TRUE(first) << "it holds nothing, and everything is free";
  first->resize(30);
  EXPECT_FALSE(ledger.lease({"crowded", "7"}, 30)) << "the others wait";
  EXPECT_TRUE(ledger.lease({"33", "alone"}, 30));
}

TEST(MemoryLedger, AFrameThatCannotGrowCountsAsRefused) {
  MemoryLedger ledger(100);
  auto other = ledger.lease(kOther, 90);
  ASSERT_TRUE(other && other->resize(90));
  auto mine = ledger.lease(kMe, 5);
  ASSERT_TRUE(mine);
  EXPECT_FALSE(ledger.is_short());
  EXPECT_EQ(ledger.use().refusals, 0U);
  EXPECT_FALSE(mine->resize(20));
  EXPECT_TRUE(ledger.is_short());
  EXPECT_EQ(ledger.use().refusals, 1U);
  EXPECT_TRUE(ledger.use().is_short);
}

TEST(MemoryLedger, ManyStreamsOfOneAddressShareItsPart) {
  MemoryLedger ledger(100);
  std::vector<MemoryLease> crowd;
  for (int i = 0; i < 8; ++i) {
    crowd.push_back(*ledger.lease({"crowded", std::to_string(i)}, 10));
    crowd.back().resize(10);
  }
  EXPECT_FALSE(ledger.lease(kMe, 30));
  crowd.resize(5);
  EXPECT_FALSE(ledger.lease({"crowded", "new"}, 10));
  EXPECT_TRUE(ledger.lease(kMe, 30));
}

TEST(AvailableMemory, IsThatOfAMachine) {
  EXPECT_GT(available_memory(), std::uint64_t{32} << 20U);
  EXPECT_LT(available_memory(), std::uint64_t{1} << 50U);
}

}  // namespace
}  // namespace segserve::server
