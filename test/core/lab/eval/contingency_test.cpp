// SPDX-License-Identifier: Apache-2.0
#include "core/lab/eval/contingency.hpp"

#include <gtest/gtest.h>

#include <numeric>

#include "core/math/random.hpp"

namespace segserve::eval {
namespace {

using Labels = std::vector<std::uint32_t>;

void expect_same(const Contingency& a, const Contingency& b) {
  const auto same_part = [](const Part& p, const Part& q) { return p.label == q.label && p.points == q.points; };
  const auto same_overlap = [](const Overlap& p, const Overlap& q) {
    return p.region == q.region && p.segment == q.segment && p.points == q.points;
  };
  EXPECT_EQ(a.points, b.points);
  EXPECT_TRUE(std::ranges::equal(a.regions, b.regions, same_part));
  EXPECT_TRUE(std::ranges::equal(a.segments, b.segments, same_part));
  EXPECT_TRUE(std::ranges::equal(a.overlaps, b.overlaps, same_overlap));
}

TEST(Coarsen, EqualsTheTableOfTheCutsLabels) {
  Random random(3);
  constexpr std::uint32_t kSupervoxels = 60;
  Labels truth(5000), supervoxels(5000);
  for (std::size_t i = 0; i < truth.size(); ++i) {
    supervoxels[i] = random.below(kSupervoxels + 1);  // 0, too
    truth[i] = random.chance(0.7) ? supervoxels[i] / 7 : random.below(12);
  }
  const Contingency fine = *tabulate(truth, supervoxels);
  for (const std::uint32_t segments : {1U, 5U, 40U}) {
    Cut cut{Labels(kSupervoxels), segments};
    for (std::uint32_t& segment : cut.segment_of_leaf) segment = 1 + random.below(segments);
    expect_same(*coarsen(fine, cut), *tabulate(truth, *label_points(supervoxels, cut)));
  }
}

TEST(Coarsen, RefusesASupervoxelThatIsNoLeaf) {
  const Contingency table = *tabulate(Labels{1, 1}, Labels{1, 4});
  const auto coarse = coarsen(table, Cut{{1, 1, 1}, 1});
  EXPECT_EQ(coarse.status().code(), absl::StatusCode::kInvalidArgument);
  EXPECT_EQ(coarse.status().message(), "supervoxel 4 is not a leaf of the tree, which has 3");
}

}  // namespace
}  // namespace segserve::eval
