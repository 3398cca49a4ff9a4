// SPDX-License-Identifier: Apache-2.0
// The kernels for AVX2 give the same bytes as those for any CPU. On a machine without AVX2 both are the same code.
#include "core/voxels/simd/voxel_kernels.hpp"

#include <gtest/gtest.h>

#include <bit>

#include "core/lab/synth/scene.hpp"
#include "core/normals/edge_aware_normals.hpp"
#include "core/normals/two_ring_normals.hpp"
#include "core/simd/simd_dispatch.hpp"
#include "core/voxels/component_bridging.hpp"
#include "core/voxels/voxel_adjacency.hpp"
#include "core/voxels/voxelization.hpp"
#include "test/core/support/clouds.hpp"
#include "test/core/support/test_frame.hpp"

namespace segserve {
namespace {

/// The bits of everything that the kernels make of a cloud.
std::vector<std::uint64_t> bits_of(const FrameContext& frame, SimdTarget cpu) {
  set_simd_target(cpu);
  VoxelGrid grid;
  VoxelAdjacency adjacency;
  std::vector<Vec3> two_ring, fitted;
  EXPECT_TRUE(Voxelization().run(frame, grid).ok());
  EXPECT_TRUE(find_adjacency(frame, grid, adjacency).ok());
  EXPECT_TRUE(bridge_components(frame, grid, {}, adjacency).ok());
  EXPECT_TRUE(TwoRingNormals().run(frame, grid, adjacency, two_ring).ok());
  Neighborhoods neighborhoods;
  EXPECT_TRUE(find_neighborhoods(frame, grid, neighborhoods).ok());
  EXPECT_TRUE(fit_neighborhood_normals(frame, grid, adjacency, neighborhoods, fitted).ok());
  std::vector<Vec3> refined = fitted;
  EXPECT_TRUE(refine_normals(frame, {}, neighborhoods, refined).ok());
  set_simd_target(best_simd_target());
  std::vector<std::uint64_t> bits(grid.key.begin(), grid.key.end());
  bits.insert(bits.end(), grid.slot_of_point.begin(), grid.slot_of_point.end());
  bits.insert(bits.end(), grid.points.begin(), grid.points.end());
  for (const auto& values : {grid.centroid, grid.color_sum, two_ring, fitted, refined}) {
    for (const Vec3& v : values) {
      for (const double number : {v.x, v.y, v.z}) bits.push_back(std::bit_cast<std::uint64_t>(number));
    }
  }
  return bits;
}

void expect_same_bits(const Cloud& cloud, const Options& options) {
  const test::TestFrame frame(cloud, options);
  const auto any = bits_of(frame, SimdTarget::kBaseline);
  EXPECT_GT(any.size(), cloud.size());
  EXPECT_EQ(bits_of(frame, best_simd_target()), any);
}

TEST(Kernels, GiveTheSameBytesInTheCameraView) {
  expect_same_bits(synth::make_tabletop({.seed = 3})->cloud, {.voxel_resolution = 0.008});
}

TEST(Kernels, GiveTheSameBytesInTheWorldView) {
  expect_same_bits(synth::make_fused_room({.seed = 3, .points = 100'000})->cloud, {.voxel_resolution = 0.02});
}

TEST(Kernels, GiveTheSameBytesWhereNeighborsFillTheirBlocks) {
  expect_same_bits(test::random_cloud(40'000, 0.12F, 0, View::world(1, 2, 3)), {.voxel_resolution = 0.01});
}

TEST(Kernels, GiveTheSameBytesAcrossBridges) {
  expect_same_bits(test::random_cloud(2000, 0.12F, 0, View::world(1, 2, 3)), {.voxel_resolution = 0.006});
}

TEST(Kernels, GiveTheSameBytesForAPartOfTheCloud) {
  const Cloud cloud = synth::make_tabletop({.seed = 3})->cloud;
  expect_same_bits(cloud, {.voxel_resolution = 0.008, .crop_max_x = 0.1, .range_max = 1.2});
}

TEST(Kernels, GiveTheSameBytesForAnyNumberOfPoints) {
  for (const std::uint32_t points : {1U, 2U, 3U, 7U, 9U, 65U}) {
    expect_same_bits(test::random_cloud(points, 0.02F, 0, View::world(1, 2, 3)), {.voxel_resolution = 0.01});
  }
}

}  // namespace
}  // namespace segserve
