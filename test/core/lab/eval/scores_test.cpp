// SPDX-License-Identifier: Apache-2.0
#include "core/lab/eval/scores.hpp"

#include <gtest/gtest.h>

#include <cmath>

namespace segserve::eval {
namespace {

using Labels = std::vector<std::uint32_t>;

//   region  points: 1: 4, 20: 3, 30: 1; one point without ground truth
const Labels kTruth{1, 1, 1, 1, 20, 20, 20, 30, 0};
const Labels kLabels{5, 5, 5, 6, 6, 6, 7, 6, 9};

TEST(Tabulate, CountsPairsAndDropsPointsWithoutTruth) {
  const Contingency table = *tabulate(kTruth, kLabels);
  EXPECT_EQ(table.points, 8U);
  ASSERT_EQ(table.regions.size(), 3U);
  ASSERT_EQ(table.segments.size(), 3U);  // 9 labels only a dropped point
  EXPECT_EQ(table.segments[1].points, 4U);
  EXPECT_EQ(table.overlaps.size(), 5U);
}

TEST(Tabulate, RefusesWhatDoesNotFit) {
  EXPECT_EQ(tabulate(Labels{1}, Labels{1, 2}).status().code(), absl::StatusCode::kInvalidArgument);
  EXPECT_EQ(tabulate(Labels{0}, Labels{1}).status().code(), absl::StatusCode::kInvalidArgument);
}

TEST(PaperScores, TakeTheSegmentOfHighestIntersectionOverUnion) {
  const Contingency table = *tabulate(kTruth, kLabels);
  // 1 -> 5: 3/4; 20 -> 6: 2/5; 30 -> 6: 1/4
  const Scores all = paper_scores(table, Regions::kAll);
  EXPECT_DOUBLE_EQ(all.wov, (4 * 0.75 + 3 * 0.4 + 1 * 0.25) / 8);
  EXPECT_DOUBLE_EQ(all.tp, (3.0 / 4 + 2.0 / 3 + 1) / 3);
  EXPECT_DOUBLE_EQ(all.fp, (0 + 2.0 / 4 + 3.0 / 4) / 3);
  EXPECT_DOUBLE_EQ(all.fn, 1 - all.tp);
  const Scores objects = paper_scores(table, Regions::kObjects);
  EXPECT_DOUBLE_EQ(objects.wov, (3 * 0.4 + 1 * 0.25) / 4);
}

TEST(OneToOneScores, LargestRegionsChooseFirstAmongFreeSegments) {
  const Contingency table = *tabulate(kTruth, kLabels);
  // 1 takes 5 (3 points), 20 takes 6 (2 of 4), 30 finds none left that it touches.
  const Scores s = one_to_one_scores(table);
  EXPECT_DOUBLE_EQ(s.tp, 5.0 / 8);
  EXPECT_DOUBLE_EQ(s.fp, 2.0 / 8);
  EXPECT_DOUBLE_EQ(s.fn, (1 + 1 + 1) / 8.0);
  EXPECT_DOUBLE_EQ(s.wov, (4 * 0.75 + 3 * 0.4) / 8);
  const double p = (3 * 4 / 3.0 + 2 * 3 / 4.0) / 8;
  EXPECT_DOUBLE_EQ(s.f, 2 * p * s.tp / (p + s.tp));
}

TEST(OneToOneScores, KeepTwoEquallyLargeRegionsApart) {
  const Scores s = one_to_one_scores(*tabulate(Labels{1, 1, 2, 2}, Labels{8, 8, 9, 9}));
  EXPECT_EQ(s.wov, 1);
  EXPECT_EQ(s.tp, 1);
}

TEST(Scores, ArePerfectForThePartitionItselfAndPoorForOneSegment) {
  const Contingency same = *tabulate(kTruth, kTruth);
  EXPECT_EQ(paper_scores(same, Regions::kAll).wov, 1);
  EXPECT_EQ(one_to_one_scores(same).f, 1);
  const Contingency one = *tabulate(kTruth, Labels(9, 1));
  EXPECT_EQ(paper_scores(one, Regions::kAll).tp, 1);  // why the paper's tp cannot choose a threshold
  EXPECT_EQ(one_to_one_scores(one).tp, 0.5);
}

TEST(VariationOfInformation, IsBothConditionalEntropies) {
  // Regions {a, a, b, b}, segments {1, 1, 1, 2}: H(R|S) = 3/4 (log2 3 - 2/3), H(S|R) = 1/2.
  const Contingency table = *tabulate(Labels{1, 1, 2, 2}, Labels{1, 1, 1, 2});
  EXPECT_NEAR(variation_of_information(table), 0.75 * (std::log2(3.0) - 2.0 / 3) + 0.5, 1e-12);
  EXPECT_EQ(variation_of_information(*tabulate(kTruth, kTruth)), 0);
}

TEST(SupervoxelScores, CountWhatLeaks) {
  const SupervoxelScores s = supervoxel_scores(*tabulate(kTruth, kLabels));
  EXPECT_DOUBLE_EQ(s.achievable_accuracy, (3 + 2 + 1) / 8.0);
  EXPECT_DOUBLE_EQ(s.undersegmentation_error, (0 + 1 + 2 + 0 + 1) / 8.0);
}

}  // namespace
}  // namespace segserve::eval
