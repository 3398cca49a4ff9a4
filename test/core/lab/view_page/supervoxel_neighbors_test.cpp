// SPDX-License-Identifier: Apache-2.0
#include "core/lab/view_page/supervoxel_neighbors.hpp"

#include <cstdint>
#include <limits>
#include <utility>
#include <vector>

#include "gmock/gmock.h"

namespace segserve::view_page {
namespace {

using testing::ElementsAre;
using testing::SizeIs;

/// Points on the x axis of a WORLD view.
Cloud on_a_line(const std::vector<float>& x) {
  Cloud cloud;
  cloud.x = x;
  cloud.y = cloud.z = std::vector<float>(x.size(), 0.25F);
  cloud.width = static_cast<std::uint32_t>(x.size());
  cloud.height = 1;
  cloud.view = View::world();
  return cloud;
}

TEST(SupervoxelNeighbors, AreThoseInVoxelsThatTouch) {
  const Cloud cloud = on_a_line({0.5F, 1.5F, 3.5F, 3.6F});
  const std::vector<std::uint32_t> supervoxels{1, 2, 3, 4};
  const auto found = supervoxel_neighbors(cloud, supervoxels, 1);
  EXPECT_THAT(found.pairs, ElementsAre(std::pair(0U, 1U), std::pair(2U, 3U)));
}

TEST(SupervoxelNeighbors, PointsThatAreNotFiniteCountForNothing) {
  constexpr float kNan = std::numeric_limits<float>::quiet_NaN(), kInfinity = std::numeric_limits<float>::infinity();
  const Cloud cloud = on_a_line({kNan, kNan, kInfinity, -kInfinity, 0.5F, 0.6F});
  const std::vector<std::uint32_t> supervoxels{1, 2, 3, 4, 5, 6};
  EXPECT_THAT(supervoxel_neighbors(cloud, supervoxels, 1).pairs, ElementsAre(std::pair(4U, 5U)));
}

TEST(SupervoxelNeighbors, AVoxelThatIsFarTooLargeDoesNotMakeVeryManyPairs) {
  constexpr std::uint32_t kSupervoxels = 20'000;
  const Cloud cloud = on_a_line(std::vector<float>(kSupervoxels, 0.5F));
  std::vector<std::uint32_t> supervoxels(kSupervoxels);
  for (std::uint32_t i = 0; i < kSupervoxels; ++i) supervoxels[i] = i + 1;
  EXPECT_THAT(supervoxel_neighbors(cloud, supervoxels, 1).pairs, SizeIs(64 * 63 / 2));
}

}  // namespace
}  // namespace segserve::view_page
