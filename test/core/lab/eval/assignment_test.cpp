// SPDX-License-Identifier: Apache-2.0
#include "core/lab/eval/assignment.hpp"

#include <gmock/gmock.h>

#include <algorithm>
#include <numeric>

#include "core/math/random.hpp"

namespace segserve::eval {
namespace {

using Weights = std::vector<double>;

double sum_of(const Weights& weights, std::size_t columns, const std::vector<std::size_t>& assigned) {
  double sum = 0;
  for (std::size_t row = 0; row < assigned.size(); ++row) sum += weights[row * columns + assigned[row]];
  return sum;
}

/// The largest sum of all assignments, by trying every order of the columns.
double best_sum(const Weights& weights, std::size_t rows, std::size_t columns) {
  std::vector<std::size_t> order(columns);
  std::iota(order.begin(), order.end(), 0U);
  double best = 0;
  do {
    best = std::max(best, sum_of(weights, columns, {order.begin(), order.begin() + static_cast<std::ptrdiff_t>(rows)}));
  } while (std::ranges::next_permutation(order).found);
  return best;
}

TEST(BestAssignment, LeavesAColumnToTheRowThatNeedsIt) {
  // Row 0 likes column 0 best, but row 1 has nothing else: 0.8 + 0.7 is more than 0.9 + 0.1.
  EXPECT_THAT(best_assignment(Weights{0.9, 0.8, 0.7, 0.1}, 2, 2), testing::ElementsAre(1, 0));
  EXPECT_THAT(best_assignment(Weights{0.9, 0.3, 0.7, 0.1}, 2, 2), testing::ElementsAre(0, 1));
}

TEST(BestAssignment, MayLeaveColumnsFree) {
  EXPECT_THAT(best_assignment(Weights{0, 0, 1, 0, 3, 2}, 2, 3), testing::ElementsAre(2, 1));
  EXPECT_TRUE(best_assignment(Weights{}, 0, 3).empty());
}

TEST(BestAssignment, IsTheBestOfAllOnRandomWeights) {
  Random random(5);
  for (int round = 0; round < 300; ++round) {
    const std::size_t rows = 1 + random.below(5);
    const std::size_t columns = rows + random.below(7 - static_cast<std::uint32_t>(rows));
    Weights weights(rows * columns);
    for (double& w : weights) w = random.chance(0.3) ? 0 : random.below(8) / 8.0;  // with ties
    const std::vector<std::size_t> assigned = best_assignment(weights, rows, columns);
    ASSERT_EQ(assigned.size(), rows);
    std::vector<std::size_t> sorted = assigned;
    std::ranges::sort(sorted);
    EXPECT_TRUE(std::ranges::adjacent_find(sorted) == sorted.end());
    EXPECT_NEAR(sum_of(weights, columns, assigned), best_sum(weights, rows, columns), 1e-12);
  }
}

}  // namespace
}  // namespace segserve::eval
