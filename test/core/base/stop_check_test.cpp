// SPDX-License-Identifier: Apache-2.0
#include "core/base/stop_check.hpp"

#include <atomic>

#include "core/base/parallel_parts.hpp"
#include "gmock/gmock.h"

namespace segserve {
namespace {

TEST(StopCheck, VisitsEveryIndexUnlessItIsStopped) {
  const StopToken never;
  StopCheck check(never);
  std::size_t visits = 0;
  EXPECT_TRUE(check.for_each(0, 10'000, [&](std::size_t) { ++visits; }));
  EXPECT_EQ(visits, 10'000U);
  EXPECT_TRUE(check.status().ok());
}

TEST(StopCheck, SkipsAllLoopsAfterItWasStopped) {
  const std::atomic<bool> cancelled = true;
  const StopToken stop(&cancelled);
  StopCheck check(stop);
  EXPECT_FALSE(check.for_each(0, 100'000, [](std::size_t) {}));
  std::size_t visits = 0;
  EXPECT_FALSE(check.for_each(0, 10, [&](std::size_t) { ++visits; }));
  EXPECT_FALSE(check.for_each_block(0, 10, [&](std::size_t, std::size_t) { ++visits; }));
  EXPECT_EQ(visits, 0U);
}

TEST(StopCheck, TellsAfterAnyAmountOfWorkThatItIsTooLate) {
  const StopToken late(nullptr, StopToken::Clock::now());
  StopCheck check(late);
  check.for_each(0, 3, [](std::size_t) {});
  EXPECT_FALSE(check.stopped()) << "it has not looked at the clock yet";
  EXPECT_EQ(check.status().code(), absl::StatusCode::kDeadlineExceeded);
}

TEST(StopCheck, ReportsAllWorkToTheMeter) {
  WorkMeter meter;
  const StopToken stop(nullptr, std::nullopt, &meter);
  {
    StopCheck check(stop);
    check.for_each(0, 5000, [](std::size_t) {});
    check.for_each(0, 7, [](std::size_t i) { return i; });
    check.for_each_block(0, 9, [](std::size_t, std::size_t) {});
  }
  EXPECT_EQ(meter.units(), 5000U + 21U + 9U);
}

TEST(ParallelParts, ReturnsWhyTheyWereStopped) {
  Executor executor(2);
  std::atomic<bool> cancelled = false;
  const StopToken stop(&cancelled);
  std::atomic<std::size_t> sum = 0;
  const auto add_up = [&](unsigned, std::size_t begin, std::size_t end, StopCheck& check) {
    check.for_each(begin, end, [&](std::size_t i) { sum += i; });
  };
  EXPECT_TRUE(parallel_parts(executor, stop, 100, add_up).ok());
  EXPECT_EQ(sum, 4950U);
  cancelled = true;
  EXPECT_EQ(parallel_parts(executor, stop, 100, add_up).code(), absl::StatusCode::kCancelled);
}

}  // namespace
}  // namespace segserve
