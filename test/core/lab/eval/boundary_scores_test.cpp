// SPDX-License-Identifier: Apache-2.0
#include "core/lab/eval/boundary_scores.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <vector>

#include "core/math/random.hpp"

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

TEST(BoundaryScores, CountWhatIsFoundAndWhatIsRight) {
  const Labels truth = split_at(6);  // boundary pixels: columns 5 and 6
  const auto scores = [&](const Labels& labels) { return *boundary_scores(truth, labels, kWidth, kHeight); };
  EXPECT_EQ(scores(truth).f, 1);
  const BoundaryScores near = scores(split_at(9));  // found: 8 and 9; 9 is three columns from 6, and 5 from 8
  EXPECT_EQ(near.precision, 0.5);
  EXPECT_EQ(near.recall, 0.5);
  EXPECT_EQ(near.f, 0.5);
  Labels twice = truth;  // one more boundary, at columns 1 and 2, is wrong
  for (std::size_t i = 0; i < twice.size(); ++i) {
    if (i % kWidth < 2) twice[i] = 7;
  }
  EXPECT_EQ(scores(twice).precision, 0.5);
  EXPECT_EQ(scores(twice).recall, 1);
  EXPECT_DOUBLE_EQ(scores(twice).f, 2.0 / 3);
}

TEST(BoundaryScores, OfOneSegmentHaveNoPrecision) {
  const auto one = boundary_scores(split_at(6), Labels(kWidth * kHeight, 3), kWidth, kHeight);
  ASSERT_TRUE(one);
  EXPECT_EQ(one->precision, std::nullopt);
  EXPECT_EQ(one->recall, 0);
  EXPECT_EQ(one->f, 0);
  EXPECT_FALSE(boundary_scores(split_at(0), split_at(6), kWidth, kHeight));
  EXPECT_FALSE(boundary_scores(Labels{1, 2}, Labels{1, 2}, 2, 1));
}

/// The pixels on the boundary of a labeling, by their four neighbors.
std::vector<std::size_t> naive_boundary(const Labels& truth, const Labels& labels, std::uint32_t width) {
  std::vector<std::size_t> pixels;
  const auto rows = static_cast<std::uint32_t>(truth.size() / width);
  for (std::uint32_t y = 0; y < rows; ++y) {
    for (std::uint32_t x = 0; x < width; ++x) {
      const auto differs = [&](std::uint32_t r, std::uint32_t c) {  // numbers below 0 wrap around
        if (r >= rows || c >= width) return false;
        const std::size_t a = y * width + x, b = r * width + c;
        return truth[a] != 0 && truth[b] != 0 && labels[a] != labels[b];
      };
      if (differs(y, x + 1) || differs(y, x - 1) || differs(y + 1, x) || differs(y - 1, x)) {
        pixels.push_back(y * width + x);
      }
    }
  }
  return pixels;
}

TEST(BoundaryScores, AreThoseOfAllPairsOfPixelsOnRandomLabels) {
  Random random(3);
  for (int round = 0; round < 100; ++round) {
    const std::uint32_t width = 2 + random.below(12), height = 2 + random.below(12);
    Labels truth(std::size_t{width} * height), labels(truth.size());
    for (std::size_t i = 0; i < truth.size(); ++i) {
      truth[i] = random.chance(0.9) ? 1 : random.below(3);
      labels[i] = random.chance(0.95) ? 1 : 2;
    }
    const auto wanted = naive_boundary(truth, truth, width), found = naive_boundary(truth, labels, width);
    const auto near = [&](const auto& some, const auto& others) {
      return static_cast<double>(std::ranges::count_if(
                 some,
                 [&](std::size_t a) {
                   return std::ranges::any_of(others, [&](std::size_t b) {
                     const auto distance = [](std::size_t p, std::size_t q) { return p > q ? p - q : q - p; };
                     return distance(a / width, b / width) <= 2 && distance(a % width, b % width) <= 2;
                   });
                 })) /
             static_cast<double>(some.size());
    };
    const auto scores = boundary_scores(truth, labels, width, height);
    ASSERT_EQ(scores.has_value(), !wanted.empty());
    if (!scores) continue;
    EXPECT_DOUBLE_EQ(scores->recall, near(wanted, found));
    EXPECT_EQ(scores->recall, boundary_recall(truth, labels, width, height));
    ASSERT_EQ(scores->precision.has_value(), !found.empty());
    if (scores->precision) {
      EXPECT_DOUBLE_EQ(*scores->precision, near(found, wanted));
    }
  }
}

}  // namespace
}  // namespace segserve::eval
