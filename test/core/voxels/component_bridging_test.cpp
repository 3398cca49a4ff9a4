// SPDX-License-Identifier: Apache-2.0
#include "core/voxels/component_bridging.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <atomic>
#include <cstdlib>
#include <map>
#include <set>

#include "core/voxels/voxelization.hpp"
#include "test/core/support/clouds.hpp"
#include "test/core/support/test_frame.hpp"

namespace segserve {
namespace {

constexpr double kVoxel = 0.01;

struct Bridged {
  VoxelGrid grid;
  VoxelAdjacency before, after;
};

Bridged bridged(const Cloud& cloud, const BridgingOptions& options = {}) {
  const test::TestFrame frame(cloud, {.voxel_resolution = kVoxel});
  Bridged b;
  EXPECT_TRUE(Voxelization().run(frame, b.grid).ok());
  EXPECT_TRUE(find_adjacency(frame, b.grid, b.before).ok());
  b.after = b.before;
  EXPECT_TRUE(bridge_components(frame, b.grid, options, b.after).ok());
  return b;
}

/// Finds the component of every voxel by flooding.
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

/// Bridges components as the definition says, by comparing all pairs of voxels.
VoxelAdjacency by_definition(const VoxelGrid& grid, const VoxelAdjacency& before, const BridgingOptions& options) {
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
    const auto is_small = [&](std::uint32_t v) {
      return std::ranges::count(component, component[v]) < static_cast<std::ptrdiff_t>(options.voxels);
    };
    for (std::uint32_t v = 0; v < n; ++v) {
      for (std::uint32_t u = 0; u < n; ++u) {
        if (component[u] == component[v] || !(is_small(u) || is_small(v))) continue;
        if (distance(grid.key[u], grid.key[v]) <= reach) neighbors[v].insert(u);
      }
    }
  }
  return rows();
}

TEST(ComponentBridging, EqualsTheDefinition) {
  // The clouds are so sparse that small components remain at every reach.
  const BridgingOptions options{.voxels = 12, .reach = 4};
  for (const std::size_t points : {60U, 150U, 400U, 1200U}) {
    const Bridged b = bridged(test::random_cloud(points, 0.3F, 0, View::world()), options);
    const VoxelAdjacency expected = by_definition(b.grid, b.before, options);
    EXPECT_EQ(b.after.offset, expected.offset) << points;
    EXPECT_EQ(b.after.neighbor, expected.neighbor) << points;
    EXPECT_NE(b.after.neighbor, b.before.neighbor) << points;
  }
}

TEST(ComponentBridging, ConnectsASurfaceThatIsSparserThanTheVoxels) {
  Cloud cloud = test::unorganized();
  test::add_patch(cloud, 0.002F, 0.002F, 0.002F, 0.4F, 0.0142F, 0);  // leaves 3 of 10 rows of voxels empty
  const Bridged b = bridged(cloud);
  EXPECT_GT(component_count(b.before), 50U);
  EXPECT_EQ(component_count(b.after), 1U);
}

TEST(ComponentBridging, KeepsLargeSurfacesApart) {
  Cloud cloud = test::unorganized();
  test::add_patch(cloud, 0.002F, 0.002F, 0.002F, 0.2F, 0.004F, 0);
  test::add_patch(cloud, 0.222F, 0.002F, 0.002F, 0.2F, 0.004F, 0);
  const Bridged b = bridged(cloud);
  EXPECT_EQ(component_count(b.after), 2U);
  EXPECT_EQ(b.after.neighbor, b.before.neighbor);
}

TEST(ComponentBridging, ReachesNoFurtherThanItMay) {
  const auto components_with_a_speck_at = [](float x) {
    Cloud cloud = test::unorganized();
    test::add_patch(cloud, 0.002F, 0.002F, 0.002F, 0.1F, 0.004F, 0);  // ends with the voxels at x = 0.09
    test::add(cloud, x, 0.05F, 0.002F, 0);
    return component_count(bridged(cloud).after);
  };
  EXPECT_EQ(components_with_a_speck_at(0.135F), 1U);  // 4 voxels away
  EXPECT_EQ(components_with_a_speck_at(0.145F), 2U);
}

TEST(ComponentBridging, StopsWhenAsked) {
  Cloud cloud = test::unorganized();
  test::add(cloud, 0, 0, 0, 0);
  Bridged b = bridged(cloud);
  const std::atomic<bool> cancelled = true;
  const test::TestFrame frame(cloud, {.voxel_resolution = kVoxel}, StopToken(&cancelled));
  EXPECT_EQ(bridge_components(frame, b.grid, {}, b.after).code(), absl::StatusCode::kCancelled);
}

/// Two walls before a camera, one 0.5 m behind the other, and pixels that fly between them at their common edge.
Cloud walls_with_flying_pixels() {
  Cloud cloud = test::unorganized(View::camera());
  for (int v = -40; v <= 40; ++v) {
    for (int u = -40; u <= 40; ++u) {
      const float z = u == 0 && v % 16 == 0 ? 1.2F + 0.01F * static_cast<float>(v % 5) : u < 0 ? 1.0F : 1.5F;
      test::add(cloud, 0.005F * static_cast<float>(u) * z, 0.005F * static_cast<float>(v) * z, z, 0);
    }
  }
  return cloud;
}

TEST(ComponentBridging, FlyingPixelsJoinWhatIsNearestInDepth) {
  const Bridged b = bridged(walls_with_flying_pixels());
  const std::vector<std::uint32_t> before = components(b.before), after = components(b.after);
  std::map<std::uint32_t, std::size_t> sizes;
  for (const std::uint32_t component : after) ++sizes[component];
  EXPECT_EQ(sizes.size(), 2U);  // The walls stay apart.
  std::size_t flying = 0;
  for (std::uint32_t v = 0; v < b.grid.size(); ++v) {
    const double z = b.grid.centroid[v].z;
    if (z < 1.1 || z > 1.4) continue;
    ++flying;
    ASSERT_EQ(b.after.of(v).size(), 1U);
    EXPECT_LT(b.grid.centroid[b.after.of(v)[0]].z, 1.1) << "the nearer wall is less far away";
  }
  EXPECT_EQ(flying, 5U);
}

}  // namespace
}  // namespace segserve
