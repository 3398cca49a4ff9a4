// SPDX-License-Identifier: Apache-2.0
#include "core/lab/eval/threshold_sweep.hpp"

#include <gtest/gtest.h>

#include "core/lab/eval/scores.hpp"
#include "core/lab/synth/scene.hpp"
#include "segserve/segment.hpp"

namespace segserve::eval {
namespace {

using Labels = std::vector<std::uint32_t>;

/// Four supervoxels of ten points; rows at heights 0.1, 0.3 and 0.6.
MergeTree tree() {
  return {.leaf_points = {10, 10, 10, 10},
          .left = {0, 2, 4},
          .right = {1, 3, 5},
          .weight = {0.1, 0.3, 0.6},
          .height = {0.1, 0.3, 0.6},
          .leaves = {2, 2, 4},
          .points = {20, 20, 40},
          .kind = {MergeKind::kMerged, MergeKind::kMerged, MergeKind::kMerged}};
}

Contingency table(const Labels& truth_of_leaf) {
  Labels truth, supervoxels;
  for (std::uint32_t leaf = 0; leaf < truth_of_leaf.size(); ++leaf) {
    truth.insert(truth.end(), 10, truth_of_leaf[leaf]);
    supervoxels.insert(supervoxels.end(), 10, leaf + 1);
  }
  return *tabulate(truth, supervoxels);
}

TEST(ThresholdSweep, TakesTheSmallestOfTheBest) {
  ThresholdSweep sweep;
  ASSERT_TRUE(sweep.add(table({1, 1, 20, 20}), tree()).ok());
  EXPECT_DOUBLE_EQ(sweep.tp(10), 0.5);   // t = 0.1: a row of height 0.1 is not below it
  EXPECT_DOUBLE_EQ(sweep.tp(11), 0.75);  // one merge
  EXPECT_DOUBLE_EQ(sweep.tp(31), 1);
  EXPECT_DOUBLE_EQ(sweep.tp(60), 1);
  EXPECT_DOUBLE_EQ(sweep.tp(61), 0.5);  // all in one
  EXPECT_EQ(sweep.best(), 31U);
}

TEST(ThresholdSweep, AveragesOverScenes) {
  ThresholdSweep sweep;
  ASSERT_TRUE(sweep.add(table({1, 1, 20, 20}), tree()).ok());
  ASSERT_TRUE(sweep.add(table({1, 1, 20, 30}), tree()).ok());  // best with one merge: 1
  EXPECT_EQ(sweep.scenes(), 2U);
  EXPECT_DOUBLE_EQ(sweep.tp(11), (0.75 + 1) / 2);
  EXPECT_DOUBLE_EQ(sweep.tp(31), (1 + 0.75) / 2);
  EXPECT_EQ(sweep.best(), 11U);
}

TEST(ThresholdSweep, EqualsSegmentingAtEachThreshold) {
  const synth::SyntheticScene scene = *synth::make_tabletop({.seed = 5, .width = 160, .height = 120});
  Options options;
  options.method = Method::kLambdaConvex;
  const Segmentation whole = *segment(scene.cloud, options);
  ThresholdSweep sweep;
  ASSERT_TRUE(sweep.add(*tabulate(scene.label, whole.supervoxels), whole.tree).ok());
  for (const std::size_t i : {0U, 7U, 15U, 40U, 100U}) {
    options.threshold = ThresholdSweep::threshold(i);
    const Segmentation cut = *segment(scene.cloud, options);
    EXPECT_EQ(sweep.tp(i), one_to_one_scores(*tabulate(scene.label, cut.labels)).tp) << *options.threshold;
  }
}

TEST(ThresholdSweep, RefusesATreeOfOtherSupervoxels) {
  ThresholdSweep sweep;
  EXPECT_EQ(sweep.add(table({1, 1, 20, 20, 30}), tree()).code(), absl::StatusCode::kInvalidArgument);
  EXPECT_EQ(sweep.scenes(), 0U);
}

}  // namespace
}  // namespace segserve::eval
