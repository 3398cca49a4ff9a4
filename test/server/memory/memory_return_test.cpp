// SPDX-License-Identifier: Apache-2.0
#include "server/memory/memory_return.hpp"

#include <chrono>
#include <memory>
#include <vector>

#include "gtest/gtest.h"

namespace segserve::server {
namespace {

using std::chrono::seconds;

constexpr std::uint64_t kMebibyte = std::uint64_t{1} << 20U;

/// Fills the heap with blocks and frees all of them but the last, so that malloc keeps them.
std::unique_ptr<std::vector<char>> leave_a_hole(std::uint64_t bytes) {
  constexpr std::size_t kBlock = 64 << 10;  // below malloc's limit for mapping a block
  std::vector<std::unique_ptr<std::vector<char>>> blocks(bytes / kBlock);
  for (auto& block : blocks) block = std::make_unique<std::vector<char>>(kBlock, 'x');
  return std::move(blocks.back());
}

TEST(MemoryReturn, GivesFreedMemoryBackOnceNothingIsLeased) {
  MemoryLedger ledger(1000);
  MemoryReturn memory_return(ledger);
  MemoryReturn::Time now{seconds(100)};
  auto lease = ledger.lease({"here", "me"}, 1);
  const auto last = leave_a_hole(200 * kMebibyte);
  const std::uint64_t full = resident_memory();
  for (int i = 0; i < 10; ++i) memory_return.on_tick(now += seconds(5));
  EXPECT_GT(resident_memory() + 50 * kMebibyte, full) << "a frame is under way, which may need it";
  lease->release();
  for (int i = 0; i < 2; ++i) memory_return.on_tick(now += seconds(5));
  EXPECT_GT(resident_memory() + 50 * kMebibyte, full) << "the next frame may come soon";
  memory_return.on_tick(now += seconds(5));
  EXPECT_LT(resident_memory() + 150 * kMebibyte, full);

  const auto of_others = leave_a_hole(200 * kMebibyte);  // such as messages that never became frames
  memory_return.on_tick(now += seconds(5));
  EXPECT_LT(resident_memory() + 150 * kMebibyte, full);
}

}  // namespace
}  // namespace segserve::server
