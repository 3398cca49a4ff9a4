// SPDX-License-Identifier: Apache-2.0
#include "core/normals/normal_orientation.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>
#include <random>
#include <vector>

#include "core/lab/synth/scene.hpp"
#include "core/normals/two_ring_normals.hpp"
#include "core/normals/visibility.hpp"
#include "core/voxels/voxelization.hpp"
#include "test/core/support/clouds.hpp"
#include "test/core/support/test_frame.hpp"

namespace segserve {
namespace {

const Options kOptions{.voxel_resolution = 0.01};

struct Oriented {
  VoxelGrid grid;
  VoxelAdjacency adjacency;
  std::vector<Vec3> turned;    // to the sensor
  std::vector<Vec3> oriented;  // by orient_hidden_normals after that
};

Oriented oriented(const Cloud& cloud) {
  const test::TestFrame frame(cloud, kOptions);
  Oriented o;
  EXPECT_TRUE(Voxelization().run(frame, o.grid).ok());
  EXPECT_TRUE(find_adjacency(frame, o.grid, o.adjacency).ok());
  EXPECT_TRUE(TwoRingNormals().run(frame, o.grid, o.adjacency, o.turned).ok());
  o.oriented = o.turned;
  EXPECT_TRUE(orient_hidden_normals(frame, o.grid, o.adjacency, o.oriented).ok());
  return o;
}

/// A board of 0.4 m x 0.4 m x 0.1 m with all its faces, seen from above.
Cloud board() {
  Cloud cloud = test::unorganized(View::world(0.2F, 0.2F, 2));
  for (float u = 0.0013F; u < 0.4F; u += 0.004F) {
    for (float v = 0.0013F; v < 0.4F; v += 0.004F) {
      test::add(cloud, u, v, 0, 0);
      test::add(cloud, u, v, 0.1F, 0);
    }
    for (float z = 0.004F; z < 0.1F; z += 0.004F) {
      test::add(cloud, u, 0, z, 0), test::add(cloud, u, 0.4F, z, 0);
      test::add(cloud, 0, u, z, 0), test::add(cloud, 0.4F, u, z, 0);
    }
  }
  return cloud;
}

/// The surface of a box along turned axes, around the origin, meters; with random points, so that no side has more by
/// design.
Cloud closed_box(float width, float depth, float height, float yaw) {
  Cloud cloud = test::unorganized(View::world());
  std::mt19937 random(11);
  const auto share = [&random] { return static_cast<float>(random() % 100'000) / 100'000 - 0.5F; };
  for (int i = 0; i < 120'000; ++i) {
    std::array<float, 3> p{share(), share(), share()};
    p[random() % 3] = random() % 2 == 0 ? -0.5F : 0.5F;
    const float x = width * p[0], y = depth * p[1];
    test::add(cloud, std::cos(yaw) * x - std::sin(yaw) * y, std::sin(yaw) * x + std::cos(yaw) * y, height * p[2], 0);
  }
  return cloud;
}

/// The share of the normals by orient_as_seen that point away from the middle.
double outward_share(const Cloud& cloud, double voxel, Preset preset = Preset::kAuto) {
  const test::TestFrame frame(cloud, {.preset = preset, .voxel_resolution = voxel});
  VoxelGrid grid;
  VoxelAdjacency adjacency;
  std::vector<Vec3> normals;
  EXPECT_TRUE(Voxelization().run(frame, grid).ok());
  EXPECT_TRUE(find_adjacency(frame, grid, adjacency).ok());
  EXPECT_TRUE(TwoRingNormals().run(frame, grid, adjacency, normals).ok());
  EXPECT_TRUE(orient_as_seen(frame, grid, adjacency, normals).ok());
  double outward = 0;
  for (std::size_t v = 0; v < grid.size(); ++v) outward += dot(grid.centroid[v], normals[v]) > 0 ? 1 : 0;
  return outward / static_cast<double>(grid.size());
}

TEST(OrientAsSeen, TheWallsOfAClosedRoomFaceItsInside) {
  for (const float yaw : {0.0F, 0.3F, 0.7F, 1.1F, 2.0F}) {
    EXPECT_LT(outward_share(closed_box(5, 4, 2.5F, yaw), 0.05), 0.02) << yaw;
  }
}

TEST(OrientAsSeen, TheSidesOfAThingFaceItsOutside) {
  for (const float yaw : {0.0F, 0.3F, 0.7F, 1.1F, 2.0F}) {
    EXPECT_GT(outward_share(closed_box(0.5F, 0.4F, 0.25F, yaw), 0.005), 0.98) << yaw;
  }
}

TEST(OrientAsSeen, APresetSaysFromWhichSideAClosedSurfaceIsSeen) {
  const Cloud room = closed_box(1.6F, 1, 0.6F, 0.3F);  // a dollhouse, or the cabin of a car
  EXPECT_GT(outward_share(room, 0.02), 0.98);
  EXPECT_LT(outward_share(room, 0.02, Preset::kRoom), 0.02);
  const Cloud house = closed_box(12, 9, 6, 0.3F);
  EXPECT_LT(outward_share(house, 0.1), 0.02);
  EXPECT_GT(outward_share(house, 0.1, Preset::kScan), 0.98);
}

TEST(OrientHiddenNormals, TurnsTheUndersideOfABoardDown) {
  const Oriented o = oriented(board());
  std::size_t top = 0, bottom = 0;
  for (std::size_t v = 0; v < o.grid.size(); ++v) {
    const Vec3& c = o.grid.centroid[v];
    const bool inner = std::fabs(c.x - 0.2) < 0.17 && std::fabs(c.y - 0.2) < 0.17;
    if (inner && c.z > 0.09) {
      ++top;
      EXPECT_GT(o.oriented[v].z, 0.99);
    } else if (inner) {
      ++bottom;
      EXPECT_GT(o.turned[v].z, 0.99);
      EXPECT_LT(o.oriented[v].z, -0.99);
    }
  }
  EXPECT_GT(top, 1000U);
  EXPECT_GT(bottom, 1000U);
}

TEST(OrientHiddenNormals, LeavesHiddenComponentsFacingTheSensor) {
  Cloud cloud = test::unorganized(View::world(0.2F, 0.2F, 2));
  test::add_patch(cloud, 0, 0, 0.5F, 0.4F, 0.004F, 0);
  test::add_patch(cloud, 0.1F, 0.1F, 0.005F, 0.2F, 0.004F, 0);  // in the shadow of the first
  const Oriented o = oriented(cloud);
  for (const Vec3& normal : o.oriented) EXPECT_GT(normal.z, 0.99);
}

TEST(OrientHiddenNormals, HardlyChangesACloudOfOneView) {
  Cloud cloud = synth::make_tabletop({.seed = 3})->cloud;
  cloud.view = View::world(0, 0, 0);
  const Oriented o = oriented(cloud);
  std::size_t changed = 0;
  for (std::size_t v = 0; v < o.grid.size(); ++v) changed += o.turned[v] == o.oriented[v] ? 0U : 1U;
  EXPECT_GT(changed, 0U);
  EXPECT_LT(static_cast<double>(changed), 0.02 * static_cast<double>(o.grid.size()));
}

TEST(OrientHiddenNormals, StopsWhenAsked) {
  const Cloud cloud = board();
  Oriented o = oriented(cloud);
  const std::atomic<bool> cancelled = true;
  const test::TestFrame frame(cloud, kOptions, StopToken(&cancelled));
  EXPECT_EQ(orient_hidden_normals(frame, o.grid, o.adjacency, o.oriented).code(), absl::StatusCode::kCancelled);
}

struct Visibility {
  VoxelGrid grid;
  std::vector<bool> visible;
};

Visibility visibility(const Cloud& cloud) {
  const test::TestFrame frame(cloud, kOptions);
  Visibility v;
  EXPECT_TRUE(Voxelization().run(frame, v.grid).ok());
  EXPECT_TRUE(find_visible_voxels(frame, v.grid, v.visible).ok());
  return v;
}

TEST(VisibleVoxels, AWallHidesWhatIsBehindItAndNothingElse) {
  Cloud cloud = test::unorganized(View::world(0, 0, 0));
  test::add_patch(cloud, -0.2F, -0.2F, 1, 0.4F, 0.004F, 0);
  test::add_patch(cloud, -1, -1, 2, 2, 0.008F, 0);
  const auto [grid, visible] = visibility(cloud);
  std::size_t hidden = 0;
  for (std::size_t v = 0; v < grid.size(); ++v) {
    const Vec3& c = grid.centroid[v];
    const double off_axis = std::max(std::fabs(c.x), std::fabs(c.y)) / c.z;
    if (c.z < 1.5 || off_axis > 0.22) {
      EXPECT_TRUE(visible[v]);
    } else if (off_axis < 0.18) {
      EXPECT_FALSE(visible[v]);
      ++hidden;
    }
  }
  EXPECT_GT(hidden, 3000U);
}

TEST(VisibleVoxels, ASlopeDoesNotHideItself) {
  Cloud cloud = test::unorganized(View::world(0, 0, 0));
  for (float u = -1; u < 1; u += 0.005F) {
    for (float y = -0.5F; y < 0.5F; y += 0.005F) test::add(cloud, u, y, 2 + 0.8F * u, 0);
  }
  const auto [grid, visible] = visibility(cloud);
  EXPECT_GT(std::ranges::count(visible, true), 0.95 * static_cast<double>(grid.size()));
}

TEST(VisibleVoxels, AVoxelAtTheSensorIsVisible) {
  Cloud cloud = test::unorganized(View::world(0, 0, 0));
  test::add(cloud, 0, 0, 0, 0);
  EXPECT_EQ(visibility(cloud).visible, std::vector<bool>{true});
}

}  // namespace
}  // namespace segserve
