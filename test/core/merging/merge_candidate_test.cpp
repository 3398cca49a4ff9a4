// SPDX-License-Identifier: Apache-2.0
#include "core/merging/merge_candidate.hpp"

#include <gtest/gtest.h>

#include <limits>
#include <tuple>
#include <vector>

namespace segserve {
namespace {

constexpr std::uint32_t kLargestId = (std::uint32_t{1} << 31) - 1;

TEST(MergeCandidate, GivesBackWhatItWasMadeOf) {
  for (const double d : {-std::numeric_limits<double>::max(), -2.5, 0.0, 1e-300, 7.0}) {
    const MergeCandidate candidate(MergePriority::kTooSmall, d, 5, kLargestId);
    EXPECT_EQ(candidate.priority(), MergePriority::kTooSmall);
    EXPECT_EQ(candidate.dissimilarity(), d);
    EXPECT_EQ(candidate.a(), 5U);
    EXPECT_EQ(candidate.b(), kLargestId);
  }
}

TEST(MergeCandidate, IsOrderedByPriorityThenDissimilarityThenIds) {
  using Fields = std::tuple<MergePriority, double, std::uint32_t, std::uint32_t>;
  std::vector<Fields> all;
  for (const MergePriority priority :
       {MergePriority::kBelowThreshold, MergePriority::kTooSmall, MergePriority::kOther}) {
    for (const double d : {-7.0, -0.5, -0.0, 0.0, 1e-9, 37.0}) {
      for (const std::uint32_t a : {0U, 3U, kLargestId}) {
        for (const std::uint32_t b : {0U, 3U, kLargestId}) all.emplace_back(priority, d, a, b);
      }
    }
  }
  const auto candidate = [](const Fields& f) { return std::make_from_tuple<MergeCandidate>(f); };
  for (const Fields& f : all) {
    EXPECT_LT(candidate(f), MergeCandidate());
    for (const Fields& g : all) {
      ASSERT_EQ(candidate(f) < candidate(g), f < g);
      ASSERT_EQ(candidate(f) == candidate(g), f == g);
    }
  }
}

}  // namespace
}  // namespace segserve
