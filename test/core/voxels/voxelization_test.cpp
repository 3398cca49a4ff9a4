// SPDX-License-Identifier: Apache-2.0
#include "core/voxels/voxelization.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <map>
#include <numeric>

#include "test/core/support/clouds.hpp"
#include "test/core/support/test_frame.hpp"

namespace segserve {
namespace {

using testing::HasSubstr;

struct Voxelized {
  absl::Status status;
  VoxelGrid grid;
};

Voxelized run(const Cloud& cloud, double resolution = 0.01, std::uint32_t threads = 1) {
  const test::TestFrame frame(cloud, {.voxel_resolution = resolution, .threads = threads});
  Voxelized result;
  result.status = Voxelization().run(frame, result.grid);
  return result;
}

std::string fault(const Cloud& cloud, double resolution = 0.01) {
  const absl::Status status = run(cloud, resolution).status;
  EXPECT_EQ(status.code(), absl::StatusCode::kInvalidArgument) << status;
  return std::string(status.message());
}

TEST(Voxelization, EqualsAnOrderedMapOfCells) {
  const Cloud cloud = test::random_cloud(5000, 0.3F, 0, View::world(0, 0, 5));
  struct Mean {
    double x = 0, y = 0, z = 0, red = 0;
    std::uint32_t n = 0;
  };
  std::map<std::array<int, 3>, Mean> cells;  // by (z, y, x), the order of the keys
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    const auto cell = [](float v) { return static_cast<int>(std::floor(v * 100.0F)); };
    Mean& mean = cells[{cell(cloud.z[i]), cell(cloud.y[i]), cell(cloud.x[i])}];
    mean.x += cloud.x[i], mean.y += cloud.y[i], mean.z += cloud.z[i], mean.red += red(cloud.rgb[i]), ++mean.n;
  }
  const auto [status, grid] = run(cloud);
  ASSERT_TRUE(status.ok());
  ASSERT_EQ(grid.size(), cells.size());
  std::size_t v = 0;
  for (const auto& [cell, mean] : cells) {
    EXPECT_EQ(grid.points[v], mean.n);
    EXPECT_NEAR(grid.centroid[v].x, mean.x / mean.n, 2e-6);
    EXPECT_NEAR(grid.centroid[v].y, mean.y / mean.n, 2e-6);
    EXPECT_NEAR(grid.centroid[v].z, mean.z / mean.n, 2e-6);
    EXPECT_EQ(grid.color_sum[v].x, mean.red);
    ++v;
  }
  EXPECT_TRUE(std::ranges::is_sorted(grid.key));
}

TEST(Voxelization, SumsOfManyPointsAreExact) {
  Cloud cloud = test::unorganized();
  constexpr std::uint32_t kPoints = 100'003;
  for (std::uint32_t i = 0; i < kPoints; ++i)
    test::add(cloud, -1500.005F, 900.005F, 1.005F, 0xffffffff - 0x200 * (i % 2));
  const VoxelGrid grid = run(cloud).grid;
  ASSERT_EQ(grid.size(), 1U);
  EXPECT_EQ(grid.points[0], kPoints);
  EXPECT_EQ(grid.color_sum[0], (Vec3{255.0 * kPoints, 254.0 * kPoints + 1, 255.0 * kPoints}));
  EXPECT_NEAR(grid.centroid[0].x, -1500.005F, 2e-6);
  EXPECT_NEAR(grid.centroid[0].y, 900.005F, 2e-6);
}

TEST(Voxelization, CameraCellsGrowWithTheDistance) {
  // At twice the distance the same angle covers twice the length, and there are as many voxels along x.
  for (const float z : {0.8F, 1.6F, 3.2F}) {
    Cloud cloud = test::unorganized(View::camera());
    for (int i = 0; i < 400; ++i) test::add(cloud, z * 0.001F * static_cast<float>(i), 0, z, 0);
    EXPECT_EQ(run(cloud, 0.01).grid.size(), 40U) << z;
  }
}

TEST(Voxelization, PointsKnowTheirVoxels) {
  Cloud cloud = test::unorganized();
  const float nan = std::numeric_limits<float>::quiet_NaN();
  test::add(cloud, 0.005F, 0, 0, 1);
  test::add(cloud, nan, 0, 0, 2);
  test::add(cloud, -0.005F, 0, 0, 3);
  test::add(cloud, 0, 0, std::numeric_limits<float>::infinity(), 4);
  test::add(cloud, 0.006F, 0, 0, 5);
  const VoxelGrid grid = run(cloud).grid;
  ASSERT_EQ(grid.size(), 2U);
  EXPECT_EQ(grid.finite_points, 3U);
  EXPECT_EQ(grid.slot_of_point[1], 0U);
  EXPECT_EQ(grid.slot_of_point[3], 0U);
  EXPECT_EQ(grid.voxel_of_slot[grid.slot_of_point[0]], 1U);
  EXPECT_EQ(grid.voxel_of_slot[grid.slot_of_point[2]], 0U);
  EXPECT_EQ(grid.voxel_of_slot[grid.slot_of_point[4]], 1U);
}

void expect_same_voxels(const VoxelGrid& a, const VoxelGrid& b) {
  EXPECT_EQ(a.key, b.key);
  EXPECT_EQ(a.points, b.points);
  EXPECT_EQ(a.centroid, b.centroid);
  EXPECT_EQ(a.color_sum, b.color_sum);
}

TEST(Voxelization, DependsNeitherOnThreadsNorOnTheOrderOfThePoints) {
  const Cloud cloud = test::random_cloud(20000, 0.5F, 1, View::camera());
  const VoxelGrid one = run(cloud).grid;
  for (const unsigned threads : {2U, 3U, 7U}) {
    const VoxelGrid many = run(cloud, 0.01, threads).grid;
    expect_same_voxels(one, many);
    for (std::size_t i = 0; i < cloud.size(); ++i) {
      ASSERT_EQ(one.voxel_of_slot[one.slot_of_point[i]], many.voxel_of_slot[many.slot_of_point[i]]);
    }
  }
  std::vector<std::uint32_t> order(cloud.size());
  std::iota(order.begin(), order.end(), 0U);
  std::ranges::shuffle(order, std::mt19937(5));
  expect_same_voxels(one, run(test::permuted(cloud, order)).grid);
}

TEST(Voxelization, MayHaveMoreThreadsThanPoints) {
  Cloud cloud = test::unorganized();
  test::add(cloud, 0, 0, 0, 0);
  EXPECT_EQ(run(cloud, 0.01, 16).grid.size(), 1U);
}

TEST(Voxelization, ASecondCloudDoesNotSeeTheFirst) {
  Voxelization voxelization;
  VoxelGrid grid;
  const Cloud large = test::random_cloud(60000, 1, 0, View::world());
  const Cloud small = test::random_cloud(50, 1, 0, View::world(), 2);
  ASSERT_TRUE(voxelization.run(test::TestFrame(large, {.voxel_resolution = 0.01}), grid).ok());
  ASSERT_TRUE(voxelization.run(test::TestFrame(small, {.voxel_resolution = 0.01}), grid).ok());
  expect_same_voxels(run(small).grid, grid);
  EXPECT_EQ(grid.finite_points, 50U);
}

TEST(Voxelization, CloudsWithoutAnyFinitePointHaveNoVoxels) {
  Cloud cloud = test::unorganized(View::camera());
  test::add(cloud, std::numeric_limits<float>::quiet_NaN(), 1, 1, 0);
  const auto [status, grid] = run(cloud);
  EXPECT_TRUE(status.ok());
  EXPECT_EQ(grid.size(), 0U);
}

TEST(Voxelization, NamesThePointBehindTheCamera) {
  Cloud cloud = test::unorganized(View::camera());
  test::add(cloud, 0, 0, 1, 0);
  test::add(cloud, 0.5F, 0, -1, 0);
  EXPECT_THAT(fault(cloud), HasSubstr("point 1 at (0.5, 0, -1): z must be above 0 in a CAMERA view"));
  cloud.z[1] = 0;
  EXPECT_THAT(fault(cloud), HasSubstr("point 1 at (0.5, 0, 0): z must be above 0"));
  cloud.view = View::world();
  EXPECT_TRUE(run(cloud).status.ok());
}

TEST(Voxelization, NamesThePointBeyondTheGrid) {
  Cloud cloud = test::unorganized();
  test::add(cloud, 0, 0, 0, 0);
  for (const float far : {1e30F, -1e30F, 3000.0F, std::numeric_limits<float>::max()}) {
    test::add(cloud, 0, far, 0, 0);
    EXPECT_THAT(fault(cloud), HasSubstr("point 1 at (0, ")) << far;
    EXPECT_THAT(fault(cloud), HasSubstr("beyond the grid, which reaches 2048 m")) << far;
    cloud.x.pop_back(), cloud.y.pop_back(), cloud.z.pop_back(), cloud.rgb.pop_back(), --cloud.width;
  }
  test::add(cloud, 0, 3000, 0, 0);
  EXPECT_TRUE(run(cloud, 0.02).status.ok()) << "larger voxels reach further";
}

TEST(Voxelization, NamesThePointTooFarAside) {
  Cloud cloud = test::unorganized(View::camera());
  test::add(cloud, 1, 0, 1e-6F, 0);
  EXPECT_THAT(fault(cloud), HasSubstr("|x/z|"));
  cloud.z[0] = 1e-40F;  // subnormal
  EXPECT_THAT(fault(cloud), HasSubstr("point 0"));
}

TEST(Voxelization, TheFirstWrongPointIsNamedWhateverTheThreads) {
  Cloud cloud = test::random_cloud(9000, 0.5F, 1, View::camera());
  for (std::size_t i = 4321; i < 4500; ++i) cloud.z[i] = -1;
  for (const unsigned threads : {1U, 2U, 5U}) {
    EXPECT_THAT(std::string(run(cloud, 0.01, threads).status.message()), HasSubstr("point 4321 "));
  }
}

TEST(Voxelization, SinglePointsThatAreNoMeasurementsAreLeftOut) {
  for (const unsigned threads : {1U, 2U, 5U}) {
    Cloud cloud = test::random_cloud(9000, 0.5F, 1, View::camera());
    cloud.z[4321] = -1;
    cloud.x[8000] = 1e30F;
    for (std::size_t i = 0; i < 3000; ++i) cloud.x[i] = cloud.y[i] = cloud.z[i] = 0;
    const auto [status, grid] = run(cloud, 0.01, threads);
    ASSERT_TRUE(status.ok()) << status;
    EXPECT_EQ(grid.zero_points, 3000U);
    EXPECT_EQ(grid.points_beyond_grid, 2U);
    EXPECT_EQ(grid.finite_points, 6000U);
    for (const std::size_t i : {0UL, 2999UL, 4321UL, 8000UL}) EXPECT_EQ(grid.slot_of_point[i], 0U) << i;
    EXPECT_NE(grid.slot_of_point[4322], 0U);
  }
}

TEST(Voxelization, StopsWhenAsked) {
  const Cloud cloud = test::random_cloud(100, 0.5F, 1, View::camera());
  VoxelGrid grid;
  const StopToken late(nullptr, StopToken::Clock::now() - std::chrono::seconds(1));
  const absl::Status status = Voxelization().run(test::TestFrame(cloud, {}, late), grid);
  EXPECT_EQ(status.code(), absl::StatusCode::kDeadlineExceeded);
}

}  // namespace
}  // namespace segserve
