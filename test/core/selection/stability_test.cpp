// SPDX-License-Identifier: Apache-2.0
#include "segserve/stability.hpp"

#include <gmock/gmock.h>

#include "test/core/merging/example_tree.hpp"
#include "test/core/selection/random_tree.hpp"

namespace segserve {
namespace {

using testing::ElementsAre;
using testing::IsEmpty;

TEST(Stability, IsTheRangeFromTheOwnHeightToThatOfTheParent) {
  EXPECT_THAT(threshold_ranges(example_tree()),
              ElementsAre(ThresholdRange{0, 0.1}, ThresholdRange{0, 0.1}, ThresholdRange{0, 0.4},
                          ThresholdRange{0, 0.4}, ThresholdRange{0, 1}, ThresholdRange{0.1, 0.4},
                          ThresholdRange{0.4, 0.4}, ThresholdRange{0.4, 1}, ThresholdRange{1, 1}));
}

TEST(Stability, OfAnEmptyTreeIsEmpty) {
  EXPECT_THAT(threshold_ranges(MergeTree()), IsEmpty());
  EXPECT_THAT(*segment_nodes(MergeTree(), 3), IsEmpty());
}

TEST(Stability, TellsAtWhichThresholdsACutHasTheSegment) {
  std::mt19937 random(20);
  for (int round = 0; round < 200; ++round) {
    const MergeTree tree = random_tree(1 + random() % 20, random);
    const auto ranges = threshold_ranges(tree);
    for (int k = 0; k <= 20; ++k) {
      const double threshold = k / 20.0;
      const Cut cut = *cut_at_threshold(tree, threshold);
      std::vector<bool> is_segment(ranges.size(), false);
      const auto nodes = segment_nodes(tree, cut.segments);
      for (const std::uint32_t node : *nodes) is_segment[node] = true;
      for (std::size_t node = 0; node < ranges.size(); ++node) {
        const bool begins = ranges[node].from < threshold || (threshold == 0 && node < tree.leaf_count());
        EXPECT_EQ(is_segment[node], begins && threshold <= ranges[node].to) << node << " at " << threshold;
      }
    }
  }
}

TEST(Stability, NamesTheNodeOfEachSegment) {
  EXPECT_THAT(*segment_nodes(example_tree(), 5), ElementsAre(2, 3, 1, 0, 4));
  EXPECT_THAT(*segment_nodes(example_tree(), 3), ElementsAre(6, 5, 4));
  EXPECT_THAT(*segment_nodes(example_tree(), 1), ElementsAre(8));
  EXPECT_EQ(segment_nodes(example_tree(), 0).status().code(), absl::StatusCode::kInvalidArgument);
}

}  // namespace
}  // namespace segserve
