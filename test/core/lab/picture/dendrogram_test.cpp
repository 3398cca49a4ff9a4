// SPDX-License-Identifier: Apache-2.0
#include "core/lab/picture/dendrogram.hpp"

#include <gmock/gmock.h>

#include <algorithm>
#include <map>
#include <random>
#include <set>

#include "core/lab/picture/dendrogram_layout.hpp"
#include "segserve/merge_tree.hpp"

namespace segserve::picture {
namespace {

/// Five supervoxels: (0, 1) at 0.1, (2, 3) at 0.2, these two at 0.6; 4 has no edge, and is joined at the end.
MergeTree small_tree() {
  return *complete({.leaf_points = {10, 20, 30, 40, 5},
                    .left = {0, 2, 5, 4},
                    .right = {1, 3, 6, 7},
                    .weight = {0.1, 0.2, 0.6, 1.0},
                    .merged_rows = 3});
}

/// A tree of m supervoxels that merges two of the nodes that are left at random.
MergeTree random_tree(std::uint32_t m) {
  std::mt19937 random(m);
  TreeColumns columns;
  columns.leaf_points.assign(m, 10);
  columns.merged_rows = m - 1;
  std::vector<std::uint32_t> open(m);
  for (std::uint32_t i = 0; i < m; ++i) open[i] = i;
  for (std::uint32_t row = 0; row + 1 < m; ++row) {
    std::swap(open[random() % open.size()], open.back());
    const std::uint32_t a = open.back();
    open.pop_back();
    std::uint32_t& b = open[random() % open.size()];
    columns.left.push_back(std::min(a, b));
    columns.right.push_back(std::max(a, b));
    columns.weight.push_back(static_cast<double>(row) / m);
    b = m + row;
  }
  return *complete(std::move(columns));
}

std::size_t count(const Image& image, std::uint32_t rgb) {
  std::size_t pixels = 0;
  for (std::size_t i = 0; i < image.rgb.size(); i += 3) {
    pixels += pack_rgb(image.rgb[i], image.rgb[i + 1], image.rgb[i + 2]) == rgb ? 1 : 0;
  }
  return pixels;
}

TEST(DendrogramLayout, PlacesMergesOverTheirChildren) {
  const DendrogramLayout layout = lay_out(small_tree(), std::vector<std::uint32_t>{1, 1, 2, 2, 3}, 100, 0.0);
  ASSERT_EQ(layout.branches.size(), 9U);
  EXPECT_EQ(layout.collapsed_branches, 0U);
  const DendrogramBranch& root = layout.branches[0];
  EXPECT_TRUE(root.is_joined);
  EXPECT_EQ(root.leaves, 5U);
  EXPECT_FALSE(root.segment);
  EXPECT_NEAR(root.left, 0.0, 1e-12);
  EXPECT_NEAR(root.right, 1.0, 1e-12);
  for (const DendrogramBranch& branch : layout.branches) {
    if (!branch.children) continue;
    const DendrogramBranch& left = layout.branches[branch.children->first];
    const DendrogramBranch& right = layout.branches[branch.children->second];
    EXPECT_NEAR(left.right, right.left, 1e-12) << "children lie side by side";
    EXPECT_GE(left.leaves, right.leaves) << "the larger is at the left";
    EXPECT_GT(branch.height, std::max(left.height, right.height));
    EXPECT_NEAR(branch.x, (left.x + right.x) / 2, 1e-12);
  }
}

TEST(DendrogramLayout, KnowsBranchesOfOneSegment) {
  const DendrogramLayout layout = lay_out(small_tree(), std::vector<std::uint32_t>{1, 1, 2, 2, 0}, 100, 0.0);
  std::multiset<std::uint32_t> segments;
  for (const DendrogramBranch& branch : layout.branches) {
    if (branch.segment) segments.insert(*branch.segment);
  }
  EXPECT_THAT(segments, testing::ElementsAre(1, 1, 1, 2, 2, 2));
}

TEST(DendrogramLayout, CollapsesWhatIsBelowTheLastMerges) {
  const MergeTree tree = random_tree(2000);
  const DendrogramLayout layout = lay_out(tree, std::vector<std::uint32_t>(2000, 1), 150, 0.0);
  EXPECT_EQ(layout.branches.size(), 301U);
  EXPECT_NEAR(layout.collapsed_below, tree.height[1999 - 150], 1e-12);
  std::size_t leaves = 0;
  for (const DendrogramBranch& branch : layout.branches) {
    if (branch.children) continue;
    leaves += branch.leaves;
    EXPECT_GT(branch.right - branch.left, 0.003) << "every end can be seen";
  }
  EXPECT_EQ(leaves, 2000U);
}

TEST(DendrogramLayout, CollapsesWhatIsTooLowToBeSeen) {
  const DendrogramLayout layout = lay_out(small_tree(), std::vector<std::uint32_t>{1, 1, 2, 2, 3}, 100, 0.15);
  EXPECT_EQ(layout.branches.size(), 7U);
  EXPECT_EQ(layout.collapsed_leaves, 2U);
  EXPECT_EQ(layout.ends, 4U);
  EXPECT_EQ(layout.collapsed_below, 0.2);
}

TEST(Dendrogram, HasTheColorsOfSegments) {
  const Image image =
      draw_dendrogram(small_tree(), std::vector<std::uint32_t>{1, 1, 2, 2, 3}, SegmentColors(), {.threshold = 0.4});
  ASSERT_EQ(image.width, 1440U);
  for (const std::uint32_t segment : {1U, 2U, 3U}) EXPECT_GT(count(image, segment_color(segment)), 500U) << segment;
}

/// The row of the picture with the line of the cut, as a height of an axis that ends at 1.
double height_of_cut(const Image& image) {
  std::map<std::uint32_t, std::size_t> pixels;
  for (std::uint32_t y = 0; y < image.height; ++y) {
    for (std::uint32_t x = 0; x < image.width; ++x) {
      const std::size_t i = 3 * (std::size_t{y} * image.width + x);
      if (pack_rgb(image.rgb[i], image.rgb[i + 1], image.rgb[i + 2]) == 0x7CC4FFU) ++pixels[y];
    }
  }
  const auto line = std::ranges::max_element(pixels, {}, [](const auto& row) { return row.second; });
  return line == pixels.end() ? -1.0 : (44.0 + 796.0 - line->first) / 796.0;
}

TEST(Dendrogram, ShowsTheCut) {
  const std::vector<std::uint32_t> segments(5, 1);
  EXPECT_NEAR(height_of_cut(draw_dendrogram(small_tree(), segments, SegmentColors(), {.threshold = 0.4})), 0.4, 2e-3);
  EXPECT_NEAR(height_of_cut(draw_dendrogram(small_tree(), segments, SegmentColors(), {.threshold = 0.85})), 0.85, 2e-3);
  // Three regions are left between the merges at 0.2 and 0.6.
  EXPECT_NEAR(height_of_cut(draw_dendrogram(small_tree(), segments, SegmentColors(), {.regions = 3})), 0.4, 2e-3);
  EXPECT_EQ(height_of_cut(draw_dendrogram(small_tree(), segments, SegmentColors(), {})), -1.0);
}

TEST(Dendrogram, OddTreesGiveAPicture) {
  EXPECT_EQ(draw_dendrogram(MergeTree{}, {}, SegmentColors(), {.threshold = 0.2}).width, 1440U);
  EXPECT_EQ(draw_dendrogram(MergeTree{}, {}, SegmentColors(), {.regions = 4}).height, 900U);
  const MergeTree one = *complete({.leaf_points = {7}, .left = {}, .right = {}, .weight = {}, .merged_rows = 0});
  EXPECT_GT(
      count(draw_dendrogram(one, std::vector<std::uint32_t>{1}, SegmentColors(), {.regions = 1}), segment_color(1)),
      100U);
  const MergeTree flat = *complete({.leaf_points = {7, 7}, .left = {0}, .right = {1}, .weight = {0}, .merged_rows = 1});
  EXPECT_EQ(draw_dendrogram(flat, std::vector<std::uint32_t>{1, 1}, SegmentColors(), {}).width, 1440U);
  EXPECT_EQ(draw_dendrogram(random_tree(5000), std::vector<std::uint32_t>(5000, 0), SegmentColors(), {}).width, 1440U);
}

TEST(SegmentsOfLeaves, AreThoseOfTheirPoints) {
  EXPECT_THAT(
      segments_of_leaves(4, std::vector<std::uint32_t>{0, 1, 3, 3, 9}, std::vector<std::uint32_t>{0, 5, 6, 6, 7}),
      testing::ElementsAre(5, 0, 6, 0));
}

}  // namespace
}  // namespace segserve::picture
