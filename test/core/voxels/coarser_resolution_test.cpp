// SPDX-License-Identifier: Apache-2.0
#include "core/voxels/coarser_resolution.hpp"

#include <atomic>

#include "core/voxels/voxel_admission.hpp"
#include "core/voxels/voxelization.hpp"
#include "gtest/gtest.h"
#include "test/core/support/clouds.hpp"
#include "test/core/support/test_frame.hpp"

namespace segserve {
namespace {

constexpr double kFineVoxel = 0.01;

std::size_t voxels_of(const Cloud& cloud, double resolution) {
  VoxelGrid grid;
  EXPECT_TRUE(Voxelization().run(test::TestFrame(cloud, {.voxel_resolution = resolution}), grid).ok());
  return grid.size();
}

TEST(CoarserResolution, IsTheFirstDoublingThatFits) {
  const Cloud cloud = test::random_cloud(20'000, 1, 0, View::world());
  for (const std::size_t voxels : {15'000UL, 3'000UL, 100UL, 10UL}) {
    const double coarser = coarser_resolution(test::TestFrame(cloud, {.voxel_resolution = kFineVoxel}), voxels);
    EXPECT_LE(voxels_of(cloud, coarser), voxels) << coarser;
    if (coarser > 2 * kFineVoxel) {
      EXPECT_GT(1.1 * static_cast<double>(voxels_of(cloud, coarser / 2)), voxels) << coarser;
    }
  }
}

TEST(VoxelAdmission, IsAskedEachTimeThatTheVoxelsHaveDoubled) {
  std::vector<std::size_t> asked;
  VoxelAdmission admission([&](std::size_t voxels) {
    asked.push_back(voxels);
    return absl::OkStatus();
  });
  for (int i = 0; i < 64; ++i) EXPECT_TRUE(admission.add(VoxelAdmission::kFirst / 4));
  EXPECT_EQ(asked,
            (std::vector<std::size_t>{VoxelAdmission::kFirst, 2 * VoxelAdmission::kFirst, 4 * VoxelAdmission::kFirst,
                                      8 * VoxelAdmission::kFirst, 16 * VoxelAdmission::kFirst}));
}

TEST(VoxelAdmission, ARefusalEndsTheVoxelization) {
  const Cloud cloud = test::random_cloud(200'000, 1, 0, View::world());
  for (const unsigned threads : {1U, 3U}) {
    std::size_t most = 0;
    VoxelAdmission admission([&](std::size_t voxels) {
      most = voxels;
      return voxels < 50'000 ? absl::OkStatus() : absl::ResourceExhaustedError("too many");
    });
    VoxelGrid grid;
    const absl::Status status =
        Voxelization().run(test::TestFrame(cloud, {.voxel_resolution = 0.002, .threads = threads}), grid, &admission);
    EXPECT_EQ(status.message(), "too many");
    EXPECT_LT(most, 80'000U);
  }
}

}  // namespace
}  // namespace segserve
