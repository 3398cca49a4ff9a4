// SPDX-License-Identifier: Apache-2.0
#include "core/lab/eval/boundary_recall.hpp"

#include <gtest/gtest.h>

#include <vector>

namespace segserve::eval {
namespace {

using Labels = std::vector<std::uint32_t>;
constexpr std::uint32_t kWidth = 12, kHeight = 4;

/// Rows that change from 1 to 2 at a column; a hole of zeros at another if asked for.
Labels split_at(std::uint32_t column, std::uint32_t hole = kWidth) {
  Labels labels;
  for (std::uint32_t i = 0; i < kWidth * kHeight; ++i) {
    const std::uint32_t c = i % kWidth;
    labels.push_back(c == hole ? 0 : c < column ? 1 : 2);
  }
  return labels;
}

std::optional<double> recall(const Labels& truth, const Labels& supervoxels) {
  return boundary_recall(truth, supervoxels, kWidth, kHeight);
}

TEST(BoundaryRecall, ForgivesTwoPixelsAndNoMore) {
  const Labels truth = split_at(6);  // boundary pixels: columns 5 and 6
  EXPECT_EQ(recall(truth, split_at(6)), 1);
  EXPECT_EQ(recall(truth, split_at(8)), 1);    // found: 7 and 8; 5 is two columns from 7
  EXPECT_EQ(recall(truth, split_at(9)), 0.5);  // found: 8 and 9; 5 is three columns away
  EXPECT_EQ(recall(truth, split_at(10)), 0);
}

TEST(BoundaryRecall, LooksAcrossRowsAlike) {
  Labels truth(4 * 12, 1), supervoxels(4 * 12, 1);  // 12 rows of 4
  for (std::size_t i = 24; i < truth.size(); ++i) truth[i] = 20;
  for (std::size_t i = 36; i < truth.size(); ++i) supervoxels[i] = 2;
  EXPECT_EQ(boundary_recall(truth, supervoxels, 4, 12), 0.5);
}

TEST(BoundaryRecall, DoesNotCountTheEdgeOfAHole) {
  EXPECT_EQ(recall(split_at(6, 6), split_at(6)), std::nullopt);  // the hole parts the regions
  EXPECT_EQ(recall(split_at(6, 2), split_at(6)), 1);
}

TEST(BoundaryRecall, TheEndOfARowIsNoNeighborOfTheNextRowsStart) {
  Labels truth(9, 1), rows(9, 1);  // 3 x 3
  truth[8] = 2;                    // boundary pixels: 5, 7 and 8
  for (std::size_t i = 3; i < 9; ++i) rows[i] = 7;
  EXPECT_EQ(boundary_recall(truth, rows, 3, 3), 1);  // by the columns alone
  EXPECT_EQ(boundary_recall(Labels{1, 1, 2, 2}, Labels{4, 4, 4, 4}, 2, 2), 0);
  const Labels stripes{1, 1, 0, 1, 2, 1, 1, 0, 1, 1};  // 5 x 2: 1 and 2 touch within the first row only
  EXPECT_EQ(boundary_recall(stripes, Labels{1, 1, 1, 1, 1, 2, 2, 2, 2, 2}, 5, 2), 1);
}

TEST(BoundaryRecall, IsUndefinedWithoutImageOrBoundary) {
  EXPECT_EQ(boundary_recall(Labels{1, 2}, Labels{1, 2}, 2, 1), std::nullopt);
  EXPECT_EQ(recall(split_at(0), split_at(6)), std::nullopt);
}

}  // namespace
}  // namespace segserve::eval
