// SPDX-License-Identifier: Apache-2.0
#include "server/memory/memory_ledger.hpp"

#include <limits>
#include <optional>
#include <utility>

#include "gtest/gtest.h"

namespace segserve::server {
namespace {

TEST(MemoryLedger, NeverLeasesMoreThanItsBudget) {
  MemoryLedger ledger(100);
  const auto first = ledger.lease(60);
  ASSERT_TRUE(first);
  EXPECT_FALSE(ledger.lease(41));
  EXPECT_FALSE(ledger.lease(std::numeric_limits<std::uint64_t>::max()));
  const auto second = ledger.lease(40);
  EXPECT_TRUE(second);
  EXPECT_EQ(ledger.leased(), 100U);
  EXPECT_FALSE(ledger.lease(1));
  EXPECT_TRUE(ledger.lease(0));
}

TEST(MemoryLedger, ALeaseGrowsIfThereIsRoomAndAlwaysShrinks) {
  MemoryLedger ledger(100);
  MemoryLease lease = *ledger.lease(60);
  const auto other = ledger.lease(30);
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
    auto first = ledger.lease(10);
    MemoryLease moved = *std::move(first);
    MemoryLease other = *ledger.lease(20);
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

TEST(AvailableMemory, IsThatOfAMachine) {
  EXPECT_GT(available_memory(), std::uint64_t{32} << 20U);
  EXPECT_LT(available_memory(), std::uint64_t{1} << 50U);
}

}  // namespace
}  // namespace segserve::server
