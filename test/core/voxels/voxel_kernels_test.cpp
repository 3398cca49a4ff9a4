// The code for AVX2 gives the bytes of the code for any CPU. On a machine without AVX2 both are the same code.
#include "core/voxels/simd/voxel_kernels.hpp"

#include <gtest/gtest.h>

#include <bit>

#include "core/lab/synth/scene.hpp"
#include "core/normals/edge_aware_normals.hpp"
#include "core/normals/two_ring_normals.hpp"
#include "core/simd/simd_dispatch.hpp"
#include "core/voxels/component_bridging.hpp"
#include "core/voxels/point_selection.hpp"
#include "core/voxels/voxel_adjacency.hpp"
#include "test/core/support/clouds.hpp"

namespace segserve {
namespace {

/// All that the kernels make of a cloud, bit by bit.
std::vector<std::uint64_t> bits_of(const Cloud& cloud, double resolution, Cpu cpu, const Selection& selection = {}) {
  use_cpu(cpu);
  VoxelizeScratch scratch;
  VoxelGrid grid;
  VoxelAdjacency adjacency;
  std::vector<Vec3> normals;
  EXPECT_TRUE(voxelize(cloud, resolution, 1, StopToken(), scratch, grid, selection).ok());
  find_adjacency(grid, adjacency);
  EXPECT_TRUE(bridge_islands(grid, cloud.view, resolution, {}, StopToken(), adjacency).ok());
  EXPECT_TRUE(compute_normals(grid, adjacency, cloud.view, 1, StopToken(), normals).ok());
  const std::vector<Vec3> by_rings = normals;
  VoxelWindows windows;
  EXPECT_TRUE(find_windows(grid, cloud.view, resolution, 1, StopToken(), windows).ok());
  EXPECT_TRUE(window_normals(grid, adjacency, cloud.view, StopToken(), windows, normals).ok());
  const std::vector<Vec3> first = normals;
  EXPECT_TRUE(refine_normals({}, StopToken(), windows, normals).ok());
  use_cpu(best_cpu());
  std::vector<std::uint64_t> bits(grid.key.begin(), grid.key.end());
  bits.insert(bits.end(), grid.slot_of_point.begin(), grid.slot_of_point.end());
  bits.insert(bits.end(), grid.points.begin(), grid.points.end());
  for (const auto& values : {grid.centroid, grid.color_sum, by_rings, first, normals}) {
    for (const Vec3& v : values) {
      for (const double number : {v.x, v.y, v.z}) bits.push_back(std::bit_cast<std::uint64_t>(number));
    }
  }
  return bits;
}

void expect_same_bits(const Cloud& cloud, double resolution, const Selection& selection = {}) {
  const auto any = bits_of(cloud, resolution, Cpu::kAny, selection);
  EXPECT_GT(any.size(), cloud.size());
  EXPECT_EQ(bits_of(cloud, resolution, best_cpu(), selection), any);
}

TEST(Kernels, GiveTheSameBytesInTheCameraView) { expect_same_bits(synth::make_tabletop({.seed = 3})->cloud, 0.008); }

TEST(Kernels, GiveTheSameBytesInTheWorldView) {
  expect_same_bits(synth::make_fused_room({.seed = 3, .points = 100'000})->cloud, 0.02);
}

TEST(Kernels, GiveTheSameBytesWhereNeighboursFillTheirBlocks) {
  expect_same_bits(test::random_cloud(40'000, 0.12F, 0, View::world(1, 2, 3)), 0.01);
}

TEST(Kernels, GiveTheSameBytesAcrossBridges) {
  expect_same_bits(test::random_cloud(2000, 0.12F, 0, View::world(1, 2, 3)), 0.006);
}

TEST(Kernels, GiveTheSameBytesOfAPartOfTheCloud) {
  const Cloud cloud = synth::make_tabletop({.seed = 3})->cloud;
  expect_same_bits(cloud, 0.008, Selection({.crop_max_x = 0.1, .range_max = 1.2}, cloud.view));
}

TEST(Kernels, GiveTheSameBytesForAnyNumberOfPoints) {
  for (const std::uint32_t points : {1U, 2U, 3U, 7U, 9U, 65U}) {
    expect_same_bits(test::random_cloud(points, 0.02F, 0, View::world(1, 2, 3)), 0.01);
  }
}

}  // namespace
}  // namespace segserve
