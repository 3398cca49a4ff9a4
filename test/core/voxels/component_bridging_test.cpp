#include "core/voxels/component_bridging.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <atomic>
#include <cstdlib>
#include <set>

#include "test/core/support/clouds.hpp"

namespace segserve {
namespace {

constexpr double kVoxel = 0.01;

struct Bridged {
  VoxelGrid grid;
  VoxelAdjacency before, after;
};

Bridged bridged(const Cloud& cloud, const IslandOptions& options = {}) {
  Bridged b;
  VoxelizeScratch scratch;
  EXPECT_TRUE(voxelize(cloud, kVoxel, 1, StopToken(), scratch, b.grid).ok());
  find_adjacency(b.grid, b.before);
  b.after = b.before;
  EXPECT_TRUE(bridge_islands(b.grid, cloud.view, kVoxel, options, StopToken(), b.after).ok());
  return b;
}

/// The component of every voxel, by flooding.
std::vector<std::uint32_t> components(const VoxelAdjacency& adjacency) {
  constexpr std::uint32_t kNone = UINT32_MAX;
  std::vector<std::uint32_t> component(adjacency.offset.size() - 1, kNone);
  for (std::uint32_t start = 0; start < component.size(); ++start) {
    if (component[start] != kNone) continue;
    std::vector<std::uint32_t> reached{start};
    component[start] = start;
    for (std::size_t i = 0; i < reached.size(); ++i) {
      for (const std::uint32_t u : adjacency.of(reached[i])) {
        if (component[u] == kNone) component[u] = start, reached.push_back(u);
      }
    }
  }
  return component;
}

std::size_t component_count(const VoxelAdjacency& adjacency) {
  const std::vector<std::uint32_t> component = components(adjacency);
  return std::set(component.begin(), component.end()).size();
}

int distance(VoxelKey a, VoxelKey b) {
  int most = 0;
  for (int axis = 0; axis < 3; ++axis) {
    const auto coordinate = [&](VoxelKey key) { return static_cast<int>(key >> (axis * kCellBits) & 0x1fffffU); };
    most = std::max(most, std::abs(coordinate(a) - coordinate(b)));
  }
  return most;
}

/// By definition, comparing all pairs.
VoxelAdjacency by_definition(const VoxelGrid& grid, const VoxelAdjacency& before, const IslandOptions& options) {
  const std::size_t n = grid.size();
  std::vector<std::set<std::uint32_t>> neighbors(n);
  for (std::uint32_t v = 0; v < n; ++v) neighbors[v].insert(before.of(v).begin(), before.of(v).end());
  const auto rows = [&] {
    VoxelAdjacency result;
    result.offset.push_back(0);
    for (const auto& row : neighbors) {
      result.neighbor.insert(result.neighbor.end(), row.begin(), row.end());
      result.offset.push_back(static_cast<std::uint32_t>(result.neighbor.size()));
    }
    return result;
  };
  for (int reach = 2; reach <= options.reach; ++reach) {
    const std::vector<std::uint32_t> component = components(rows());
    const auto island = [&](std::uint32_t v) {
      return static_cast<double>(std::ranges::count(component, component[v])) * kVoxel * kVoxel < options.area;
    };
    for (std::uint32_t v = 0; v < n; ++v) {
      for (std::uint32_t u = 0; u < n; ++u) {
        if (component[u] == component[v] || !(island(u) || island(v))) continue;
        if (distance(grid.key[u], grid.key[v]) <= reach) neighbors[v].insert(u);
      }
    }
  }
  return rows();
}

TEST(Islands, EqualTheDefinition) {
  // Sparse enough for islands at every reach; 11.5 voxels are no island, whatever the rounding.
  const IslandOptions options{.area = 11.5 * kVoxel * kVoxel, .reach = 4};
  for (const std::size_t points : {60U, 150U, 400U, 1200U}) {
    const Bridged b = bridged(test::random_cloud(points, 0.3F, 0, View::world()), options);
    const VoxelAdjacency expected = by_definition(b.grid, b.before, options);
    EXPECT_EQ(b.after.offset, expected.offset) << points;
    EXPECT_EQ(b.after.neighbor, expected.neighbor) << points;
    EXPECT_NE(b.after.neighbor, b.before.neighbor) << points;
  }
}

TEST(Islands, ASurfaceSparserThanTheVoxelsHangsTogether) {
  Cloud cloud = test::unorganised();
  test::add_patch(cloud, 0.002F, 0.002F, 0.002F, 0.4F, 0.0142F, 0);  // 3 of 10 rows of voxels are empty
  const Bridged b = bridged(cloud);
  EXPECT_GT(component_count(b.before), 50U);
  EXPECT_EQ(component_count(b.after), 1U);
}

TEST(Islands, LargeSurfacesWithAGapBetweenThemStayApart) {
  Cloud cloud = test::unorganised();
  test::add_patch(cloud, 0.002F, 0.002F, 0.002F, 0.2F, 0.004F, 0);
  test::add_patch(cloud, 0.222F, 0.002F, 0.002F, 0.2F, 0.004F, 0);
  const Bridged b = bridged(cloud);
  EXPECT_EQ(component_count(b.after), 2U);
  EXPECT_EQ(b.after.neighbor, b.before.neighbor);
}

TEST(Islands, ReachNoFurtherThanTheyMay) {
  const auto components_with_a_speck_at = [](float x) {
    Cloud cloud = test::unorganised();
    test::add_patch(cloud, 0.002F, 0.002F, 0.002F, 0.1F, 0.004F, 0);  // its last voxels are those of x = 0.09
    test::add(cloud, x, 0.05F, 0.002F, 0);
    return component_count(bridged(cloud).after);
  };
  EXPECT_EQ(components_with_a_speck_at(0.135F), 1U);  // 4 voxels on
  EXPECT_EQ(components_with_a_speck_at(0.145F), 2U);
}

TEST(Islands, EndEarlyWhenAsked) {
  Cloud cloud = test::unorganised();
  test::add(cloud, 0, 0, 0, 0);
  VoxelizeScratch scratch;
  VoxelGrid grid;
  VoxelAdjacency adjacency;
  ASSERT_TRUE(voxelize(cloud, kVoxel, 1, StopToken(), scratch, grid).ok());
  find_adjacency(grid, adjacency);
  const std::atomic<bool> cancelled = true;
  const absl::Status status = bridge_islands(grid, cloud.view, kVoxel, {}, StopToken(&cancelled), adjacency);
  EXPECT_EQ(status.code(), absl::StatusCode::kCancelled);
}

}  // namespace
}  // namespace segserve
