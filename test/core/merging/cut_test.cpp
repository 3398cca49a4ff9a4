// SPDX-License-Identifier: Apache-2.0
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "segserve/merge_tree.hpp"
#include "test/core/merging/example_tree.hpp"

namespace segserve {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;

TEST(Cut, ByThresholdAppliesTheLeadingRowsBelowIt) {
  const MergeTree tree = example_tree();
  EXPECT_EQ(cut_at_threshold(tree, 0)->segments, 5U);
  EXPECT_EQ(cut_at_threshold(tree, 0.1)->segments, 5U);  // The paper stops at the first minimum >= t.
  EXPECT_EQ(cut_at_threshold(tree, 0.11)->segments, 4U);
  EXPECT_EQ(cut_at_threshold(tree, 0.3)->segments, 4U);  // The later row of weight 0.2 is not applied.
  EXPECT_EQ(cut_at_threshold(tree, 0.41)->segments, 2U);
  EXPECT_EQ(cut_at_threshold(tree, 1)->segments, 2U);  // Components stay apart at any threshold.
}

TEST(Cut, ByRegionsGivesExactlySoMany) {
  const MergeTree tree = example_tree();
  for (std::uint32_t d = 1; d <= 7; ++d) EXPECT_EQ(cut_to_regions(tree, d)->segments, std::min(d, 5U));
}

TEST(Cut, NumbersSegmentsBySizeThenBySmallestLeaf) {
  const MergeTree tree = example_tree();
  EXPECT_THAT(cut_to_regions(tree, 5)->segment_of_leaf, ElementsAre(4, 3, 1, 2, 5));
  EXPECT_THAT(cut_to_regions(tree, 4)->segment_of_leaf, ElementsAre(1, 1, 2, 3, 4));
  EXPECT_THAT(cut_to_regions(tree, 2)->segment_of_leaf, ElementsAre(1, 1, 1, 1, 2));
}

TEST(Cut, LabelsPoints) {
  const Cut cut = *cut_to_regions(example_tree(), 3);
  EXPECT_THAT(*label_points(std::vector<std::uint32_t>{0, 1, 2, 3, 4, 5, 0}, cut), ElementsAre(0, 2, 2, 1, 1, 3, 0));
  const auto wrong = label_points(std::vector<std::uint32_t>{1, 6}, cut);
  EXPECT_EQ(wrong.status().code(), absl::StatusCode::kInvalidArgument);
  EXPECT_THAT(std::string(wrong.status().message()), HasSubstr("supervoxel 6"));
}

TEST(Cut, RefusesNonsense) {
  const MergeTree tree = example_tree();
  for (const double threshold : {-1.0, 1.5, std::numeric_limits<double>::quiet_NaN()}) {
    EXPECT_EQ(cut_at_threshold(tree, threshold).status().code(), absl::StatusCode::kInvalidArgument) << threshold;
  }
  EXPECT_EQ(cut_to_regions(tree, 0).status().code(), absl::StatusCode::kInvalidArgument);
}

TEST(Cut, OfAnEmptyTreeIsEmpty) {
  EXPECT_EQ(cut_at_threshold({}, 0.5)->segments, 0U);
  EXPECT_EQ(cut_to_regions({}, 3)->segments, 0U);
}

}  // namespace
}  // namespace segserve
