// SPDX-License-Identifier: Apache-2.0
#include "segserve/merge_tree.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <limits>
#include <string>

#include "test/core/merging/example_tree.hpp"

namespace segserve {
namespace {

using testing::HasSubstr;

TEST(MergeTreeCheck, AcceptsATree) {
  EXPECT_TRUE(check(example_tree()).ok());
  EXPECT_TRUE(check(MergeTree{}).ok());
}

TEST(MergeTreeCheck, NamesWhatIsWrong) {
  const auto fault = [](auto&& change) {
    MergeTree tree = example_tree();
    change(tree);
    return std::string(check(tree).message());
  };
  EXPECT_THAT(fault([](MergeTree& t) { t.left.pop_back(); }), HasSubstr("5 leaves take 4 rows, not 3"));
  EXPECT_THAT(fault([](MergeTree& t) { t.height.pop_back(); }), HasSubstr("differ in length"));
  EXPECT_THAT(fault([](MergeTree& t) { t.right[1] = 7; }), HasSubstr("row 1"));
  EXPECT_THAT(fault([](MergeTree& t) { t.left[1] = 1; }), HasSubstr("merged twice"));
  EXPECT_THAT(fault([](MergeTree& t) { t.weight[0] = std::numeric_limits<double>::quiet_NaN(); }), HasSubstr("weight"));
  EXPECT_THAT(fault([](MergeTree& t) { t.height[2] = 0.2; }), HasSubstr("height"));
  EXPECT_THAT(fault([](MergeTree& t) { t.points[3] = 94; }), HasSubstr("sum"));
  EXPECT_THAT(fault([](MergeTree& t) { t.kind[1] = MergeKind::kJoined; }), HasSubstr("JOINED, but its weight is 0.4"));
  EXPECT_THAT(fault([](MergeTree& t) {
                t.kind[1] = MergeKind::kJoined;
                t.weight[1] = t.height[1] = t.height[2] = 1;
              }),
              HasSubstr("row 2: a MERGED row comes after"));
}

/// The columns of the example that are sent.
TreeColumns example_columns() {
  const MergeTree tree = example_tree();
  return {
      .leaf_points = tree.leaf_points, .left = tree.left, .right = tree.right, .weight = tree.weight, .merged_rows = 3};
}

TEST(MergeTreeComplete, DerivesTheOtherColumns) {
  EXPECT_EQ(complete(example_columns()).value(), example_tree());
  EXPECT_EQ(complete({}).value(), MergeTree{});
  const TreeColumns single{.leaf_points = {7}, .left = {}, .right = {}, .weight = {}};
  EXPECT_EQ(complete(single)->leaf_points, std::vector<std::uint32_t>{7});
}

TEST(MergeTreeComplete, NamesWhatIsWrong) {
  const auto fault = [](auto&& change) {
    TreeColumns columns = example_columns();
    change(columns);
    const absl::Status status = complete(std::move(columns)).status();
    EXPECT_EQ(status.code(), absl::StatusCode::kInvalidArgument);
    return std::string(status.message());
  };
  constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THAT(fault([](TreeColumns& c) { c.leaf_points.pop_back(); }), HasSubstr("4 leaves take 3 rows, not 4"));
  EXPECT_THAT(fault([](TreeColumns& c) { c.leaf_points.clear(); }), HasSubstr("0 leaves take 0 rows, not 4"));
  EXPECT_THAT(fault([](TreeColumns& c) { c.right.pop_back(); }), HasSubstr("differ in length"));
  EXPECT_THAT(fault([](TreeColumns& c) { c.weight.push_back(1); }), HasSubstr("differ in length"));
  EXPECT_THAT(fault([](TreeColumns& c) { c.merged_rows = 5; }), HasSubstr("5 of 4 rows are MERGED"));
  EXPECT_THAT(fault([](TreeColumns& c) { c.merged_rows = 2; }),
              HasSubstr("row 2: it is JOINED, but its weight is 0.2"));
  EXPECT_THAT(fault([](TreeColumns& c) { c.left[1] = 3; }), HasSubstr("row 1: left 3 and right 3"));
  EXPECT_THAT(fault([](TreeColumns& c) { c.right[1] = 6; }),
              HasSubstr("row 1: left 2 and right 6"));  // The node of the row itself.
  EXPECT_THAT(fault([](TreeColumns& c) { c.right[3] = 0xffffffff; }), HasSubstr("row 3: left 4 and right 4294967295"));
  EXPECT_THAT(fault([](TreeColumns& c) { c.left[1] = 1; }), HasSubstr("row 1: a node is merged twice"));
  EXPECT_THAT(fault([](TreeColumns& c) { c.weight[2] = -0.1; }), HasSubstr("row 2: weight -0.1"));
  EXPECT_THAT(fault([](TreeColumns& c) { c.weight[2] = kNan; }), HasSubstr("row 2: weight nan"));
  EXPECT_THAT(fault([](TreeColumns& c) { c.leaf_points[0] = c.leaf_points[4] = 0xffffffff; }),
              HasSubstr("8589934670 points"));
}

}  // namespace
}  // namespace segserve
