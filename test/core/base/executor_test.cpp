// SPDX-License-Identifier: Apache-2.0
#include "core/base/executor.hpp"

#include <atomic>
#include <cstddef>
#include <new>
#include <stdexcept>
#include <vector>

#include "gmock/gmock.h"

namespace segserve {
namespace {

using testing::Each;

class ExecutorTest : public testing::TestWithParam<unsigned> {};
INSTANTIATE_TEST_SUITE_P(Threads, ExecutorTest, testing::Values(1U, 2U, 3U, 8U));

TEST_P(ExecutorTest, DividesAllIndicesAmongItsParts) {
  Executor executor(GetParam());
  for (const std::size_t count : {0UL, 1UL, 7UL, 1000UL}) {
    std::vector<int> visits(count, 0);
    std::vector<int> parts(executor.threads(), 0);
    executor.for_each_part(count, [&](unsigned part, std::size_t begin, std::size_t end) {
      ++parts[part];
      for (std::size_t i = begin; i < end; ++i) ++visits[i];
    });
    EXPECT_THAT(visits, Each(1)) << count;
    EXPECT_THAT(parts, Each(1)) << count;
  }
}

TEST_P(ExecutorTest, ThrowsToTheCallerWhatAPartThrows) {
  Executor executor(GetParam());
  const auto fail_in_the_last_part = [&](unsigned part, std::size_t, std::size_t) {
    if (part + 1 == executor.threads()) throw std::bad_alloc();
  };
  EXPECT_THROW(executor.for_each_part(100, fail_in_the_last_part), std::bad_alloc);

  std::atomic<std::size_t> sum = 0;  // It is of use after an exception.
  executor.for_each_range(100, [&](std::size_t begin, std::size_t end) { sum += end - begin; });
  EXPECT_EQ(sum, 100U);
}

TEST(ExecutorTest, HasAtLeastOneThread) { EXPECT_EQ(Executor(0).threads(), 1U); }

}  // namespace
}  // namespace segserve
