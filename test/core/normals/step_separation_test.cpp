// SPDX-License-Identifier: Apache-2.0
#include "core/normals/step_separation.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstdint>
#include <vector>

#include "core/base/executor.hpp"
#include "test/core/support/clouds.hpp"

namespace segserve {
namespace {

/// Voxels in a row that are all neighbors of one another, at 10 m from a LiDAR, where they are 10 cm wide.
class StepSeparation : public testing::Test {
 protected:
  void add(const Vec3& position, const Vec3& normal) {
    grid_.key.push_back(grid_.key.size());
    grid_.centroid.push_back(position);
    normals_.push_back(normal);
  }

  std::vector<std::uint32_t> neighbors_of_first(bool is_sweep = true) {
    FrameContext frame(cloud_, {}, executor_);
    frame.scale.voxel = 0.01;
    if (is_sweep) frame.scale.sweep = SweepProjection{};
    VoxelAdjacency adjacency;
    adjacency.offset.push_back(0);
    const auto count = static_cast<std::uint32_t>(grid_.size());
    for (std::uint32_t v = 0; v < count; ++v) {
      for (std::uint32_t u = 0; u < count; ++u) {
        if (u != v) adjacency.neighbor.push_back(u);
      }
      adjacency.offset.push_back(static_cast<std::uint32_t>(adjacency.neighbor.size()));
    }
    EXPECT_TRUE(separate_steps(frame, grid_, normals_, adjacency).ok());
    for (std::uint32_t v = 1; v < count; ++v) {
      const auto first = adjacency.of(0), other = adjacency.of(v);
      EXPECT_EQ(std::count(first.begin(), first.end(), v), std::count(other.begin(), other.end(), 0)) << v;
    }
    EXPECT_EQ(adjacency.neighbor.size(), adjacency.offset.back());
    return {adjacency.of(0).begin(), adjacency.of(0).end()};
  }

  Cloud cloud_ = test::unorganized(View::world(0, 0, 0));
  Executor executor_{1};
  VoxelGrid grid_;
  std::vector<Vec3> normals_;
};

constexpr Vec3 kUp{0, 0, 1}, kAhead{-1, 0, 0}, kUnknown{};

TEST_F(StepSeparation, KeepsWhatLiesOnAPlaneAtAnyDistance) {
  add({10, 0, -1.8}, kUp);
  add({12, 0, -1.8}, kUp);
  add({15, 0, -1.75}, kUnknown);
  EXPECT_EQ(neighbors_of_first(), (std::vector<std::uint32_t>{1, 2}));
}

TEST_F(StepSeparation, PartsWhatStandsBehindSomething) {
  add({10, 0, 0}, kAhead);
  add({12, 0, 0}, kAhead);
  add({12, 0, 0.1}, kUnknown);
  add({10.1, 0, 0}, kUnknown);
  EXPECT_EQ(neighbors_of_first(), std::vector<std::uint32_t>{3}) << "the last one is close";
}

TEST_F(StepSeparation, OnePlaneIsEnough) {
  add({10, 0, -1.8}, kUp);
  add({10.5, 0, -1.75}, kAhead);
  EXPECT_EQ(neighbors_of_first(), std::vector<std::uint32_t>{1}) << "a car stands on the ground";
}

TEST_F(StepSeparation, LeavesOtherCloudsAlone) {
  add({10, 0, 0}, kAhead);
  add({12, 0, 0}, kAhead);
  EXPECT_EQ(neighbors_of_first(false), std::vector<std::uint32_t>{1});
}

}  // namespace
}  // namespace segserve
