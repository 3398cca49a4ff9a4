// SPDX-License-Identifier: Apache-2.0
#include "core/normals/two_ring_normals.hpp"

#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>
#include <cmath>

#include "core/voxels/voxel_adjacency.hpp"
#include "core/voxels/voxelization.hpp"
#include "test/core/support/clouds.hpp"
#include "test/core/support/test_frame.hpp"

namespace segserve {
namespace {

struct TwoRing {
  VoxelGrid grid;
  VoxelAdjacency adjacency;
  std::vector<Vec3> normals;
};

TwoRing two_ring_normals_of(const Cloud& cloud, std::uint32_t threads = 1) {
  const test::TestFrame frame(cloud, {.voxel_resolution = 0.01, .threads = threads});
  TwoRing n;
  EXPECT_TRUE(Voxelization().run(frame, n.grid).ok());
  EXPECT_TRUE(find_adjacency(frame, n.grid, n.adjacency).ok());
  EXPECT_TRUE(TwoRingNormals().run(frame, n.grid, n.adjacency, n.normals).ok());
  return n;
}

int signed_coordinate(VoxelKey key, int axis) {
  return static_cast<int>(key >> (axis * kCellBits) & ((1U << kCellBits) - 1)) - kCellBias;
}

TEST(Adjacency, EqualsComparingAllPairs) {
  // The cloud is dense enough for all 26 neighbors, and around the origin, so that coordinates of cells change sign.
  const auto [grid, adjacency, normals] = two_ring_normals_of(test::random_cloud(3000, 0.12F, 0, View::world()));
  ASSERT_EQ(adjacency.offset.size(), grid.size() + 1);
  std::size_t most = 0;
  for (std::uint32_t v = 0; v < grid.size(); ++v) {
    std::vector<std::uint32_t> expected;
    for (std::uint32_t u = 0; u < grid.size(); ++u) {
      bool near = u != v;
      for (int a = 0; a < 3; ++a)
        near = near && std::abs(signed_coordinate(grid.key[v], a) - signed_coordinate(grid.key[u], a)) <= 1;
      if (near) expected.push_back(u);
    }
    const auto neighbors = adjacency.of(v);
    ASSERT_EQ(std::vector(neighbors.begin(), neighbors.end()), expected);
    most = std::max(most, expected.size());
  }
  EXPECT_EQ(most, 26U);
}

TEST(TwoRingNormals, FitTheTwoRingsAsOftenAsPathsLeadThere) {
  const TwoRing n = two_ring_normals_of(test::random_cloud(400, 0.12F, 0, View::world(0.1F, 0.2F, 3)));
  const VoxelGrid& grid = n.grid;
  const std::vector<Vec3>& normals = n.normals;
  for (std::uint32_t v = 0; v < grid.size(); ++v) {
    std::vector<std::uint32_t> list{v};  // as PCL makes it, for which a voxel is among its own neighbors
    const auto with_itself = [&](std::uint32_t w) {
      std::vector<std::uint32_t> neighbors(n.adjacency.of(w).begin(), n.adjacency.of(w).end());
      neighbors.push_back(w);
      return neighbors;
    };
    for (const std::uint32_t u : with_itself(v)) {
      list.push_back(u);
      for (const std::uint32_t w : with_itself(u)) list.push_back(w);
    }
    Eigen::Vector3d mean = Eigen::Vector3d::Zero();
    for (const std::uint32_t u : list)
      mean += Eigen::Vector3d(grid.centroid[u].x, grid.centroid[u].y, grid.centroid[u].z);
    mean /= static_cast<double>(list.size());
    Eigen::Matrix3d scatter = Eigen::Matrix3d::Zero();
    for (const std::uint32_t u : list) {
      const Eigen::Vector3d d = Eigen::Vector3d(grid.centroid[u].x, grid.centroid[u].y, grid.centroid[u].z) - mean;
      scatter += d * d.transpose();
    }
    const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver(scatter);
    const Eigen::Vector3d values = solver.eigenvalues();
    if (values[1] - values[0] <= 0.05 * values[2]) continue;  // This is hardly a plane, so its normal is uncertain.
    const Eigen::Vector3d expected = solver.eigenvectors().col(0);
    EXPECT_NEAR(std::fabs(expected.dot(Eigen::Vector3d(normals[v].x, normals[v].y, normals[v].z))), 1, 1e-6);
    EXPECT_GE(dot(normals[v], Vec3{0.1F, 0.2F, 3} - grid.centroid[v]), 0) << "turned to the sensor";
  }
}

TEST(TwoRingNormals, AreUndefinedOnlyWhereNoPlaneIs) {
  Cloud cloud = test::unorganized();
  test::add(cloud, 5, 5, 5, 0);                                                                              // alone
  for (int i = 0; i < 30; ++i) test::add(cloud, 0.01F * static_cast<float>(i) + 0.005F, 0.005F, 0.005F, 0);  // a line
  test::add_patch(cloud, 1, 1, 0.005F, 0.2F, 0.005F, 0);
  const auto [grid, adjacency, normals] = two_ring_normals_of(cloud);
  for (std::size_t v = 0; v < grid.size(); ++v) {
    const bool on_patch = grid.centroid[v].x > 0.9 && grid.centroid[v].x < 2;
    EXPECT_NEAR(norm(normals[v]), on_patch ? 1 : 0, 1e-9);
    if (on_patch) {
      EXPECT_NEAR(normals[v].z, 1, 1e-9);
    }
  }
}

TEST(TwoRingNormals, AreConsistentWithoutASensor) {
  // This is the part of a sphere from below the equator up. Most of it faces up, so all normals must point outwards.
  Cloud cloud = test::unorganized(View::world());
  for (double theta = 0; theta < 1.9; theta += 0.01) {
    for (double phi = 0; phi < 6.28; phi += 0.01 / std::max(0.05, std::sin(theta))) {
      test::add(cloud, static_cast<float>(0.3 * std::sin(theta) * std::cos(phi)),
                static_cast<float>(0.3 * std::sin(theta) * std::sin(phi)), static_cast<float>(0.3 * std::cos(theta)),
                0);
    }
  }
  const auto [grid, adjacency, normals] = two_ring_normals_of(cloud);
  for (std::size_t v = 0; v < grid.size(); ++v) EXPECT_GT(dot(normals[v], unit(grid.centroid[v])), 0.8);
}

TEST(TwoRingNormals, DoNotDependOnThreads) {
  const Cloud cloud = test::random_cloud(3000, 0.3F, 1, View::camera());
  EXPECT_EQ(two_ring_normals_of(cloud, 1).normals, two_ring_normals_of(cloud, 5).normals);
}

}  // namespace
}  // namespace segserve
