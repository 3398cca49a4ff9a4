// SPDX-License-Identifier: Apache-2.0
#include "client/load_test/hdr_histogram.hpp"

#include <algorithm>
#include <cmath>
#include <random>
#include <vector>

#include "gmock/gmock.h"

namespace segserve::bench {
namespace {

TEST(HdrHistogram, BucketsHaveNoGapsAndAreNarrow) {
  std::uint64_t next = 0;
  for (std::size_t i = 0; next <= HdrHistogram::kHighest; ++i) {
    ASSERT_EQ(HdrHistogram::lowest_of(i), next);
    ASSERT_EQ(HdrHistogram::index_of(next), i);
    ASSERT_EQ(HdrHistogram::index_of(HdrHistogram::highest_of(i)), i);
    const std::uint64_t width = HdrHistogram::highest_of(i) - next + 1;
    ASSERT_TRUE(width == 1 || 1024 * width <= next) << next;
    next += width;
    ASSERT_LT(i, 30'000U) << "the memory is bounded";
  }
}

TEST(HdrHistogram, PercentilesAreRightWithinATenthOfAPercent) {
  std::mt19937_64 random(1);
  std::lognormal_distribution<double> distribution(10, 2);  // from tens of microseconds to minutes
  std::vector<std::uint64_t> values;
  HdrHistogram histogram;
  for (int i = 0; i < 100'000; ++i) {
    values.push_back(static_cast<std::uint64_t>(distribution(random)));
    histogram.record(values.back());
  }
  std::ranges::sort(values);
  for (std::uint64_t rank = 1; rank <= values.size(); rank += 97) {
    const auto exact = static_cast<double>(values[rank - 1]);
    ASSERT_NEAR(static_cast<double>(histogram.value_at_rank(rank)), exact, 0.001 * exact) << rank;
  }
  EXPECT_EQ(histogram.value_at_rank(values.size()), values.back());
  EXPECT_EQ(histogram.max(), values.back());
}

TEST(HdrHistogram, SumsAreThoseOfOneHistogram) {
  HdrHistogram all, first, second;
  for (std::uint64_t i = 1; i < 100'000; i += 7) {
    all.record(i * i);
    (i % 2 == 0 ? first : second).record(i * i);
  }
  first.add(second);
  EXPECT_EQ(first.counts(), all.counts());
  EXPECT_EQ(first.count(), all.count());
  EXPECT_EQ(first.max(), all.max());
  EXPECT_DOUBLE_EQ(first.mean(), all.mean());
}

TEST(HdrHistogram, ValuesBeyondTheHighestCountAsIt) {
  HdrHistogram histogram;
  histogram.record(~std::uint64_t{0}, 3);
  EXPECT_EQ(histogram.max(), HdrHistogram::kHighest);
  EXPECT_EQ(histogram.count(), 3U);
  EXPECT_EQ(HdrHistogram{}.value_at_rank(1), 0U);
}

}  // namespace
}  // namespace segserve::bench
