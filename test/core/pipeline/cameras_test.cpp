// SPDX-License-Identifier: Apache-2.0
// Clouds that several cameras see together.
#include "segserve/cameras.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <map>
#include <numeric>
#include <random>
#include <vector>

#include "core/lab/synth/table_rig.hpp"
#include "core/normals/edge_aware_normals.hpp"
#include "core/normals/two_ring_normals.hpp"
#include "core/voxels/seeing_cameras.hpp"
#include "core/voxels/voxelization.hpp"
#include "segserve/segment.hpp"
#include "segserve/tracking.hpp"
#include "test/core/support/clouds.hpp"
#include "test/core/support/test_frame.hpp"

namespace segserve {
namespace {

/// What `cameras` cameras around a table see, and what they shall find.
struct Rig {
  Cloud cloud;
  std::vector<std::uint32_t> truth;
  std::vector<std::size_t> first;  ///< the first point of each camera, and the number of all points
};

Rig rig(std::uint64_t seed, std::uint32_t cameras) {
  const auto views = synth::make_tabletop_rig(
      {.seed = seed, .width = 320, .height = 240, .objects = 6, .stacked = 0, .clutter = 0, .compact = true}, cameras);
  EXPECT_TRUE(views.ok()) << views.status();
  Rig result;
  std::vector<CameraCloud> clouds;
  for (const synth::RigView& view : *views) {
    clouds.push_back({view.scene.cloud, view.pose});
    result.first.push_back(result.truth.size());
    result.truth.insert(result.truth.end(), view.scene.label.begin(), view.scene.label.end());
  }
  result.first.push_back(result.truth.size());
  auto merged = merge_cameras(clouds);
  EXPECT_TRUE(merged.ok()) << merged.status();
  result.cloud = *std::move(merged);
  return result;
}

Segmentation segmented(const CloudView& cloud, const Options& options = {}) {
  auto result = segment(cloud, options);
  EXPECT_TRUE(result.ok()) << result.status();
  return *std::move(result);
}

/// The segment that holds most of the points of an object in a part of the cloud, and its share of them.
struct Share {
  std::uint32_t segment = 0;
  double share = 0;
  std::size_t points = 0;
};
Share share_of(std::uint32_t object, const Rig& rig, const Segmentation& result, std::size_t first, std::size_t last) {
  std::map<std::uint32_t, std::size_t> points;
  Share share;
  for (std::size_t i = first; i < last; ++i) {
    if (rig.truth[i] != object || result.labels[i] == 0) continue;
    ++points[result.labels[i]];
    ++share.points;
  }
  for (const auto& [segment, count] : points) {
    const double part = static_cast<double>(count) / static_cast<double>(share.points);
    if (part > share.share) share.segment = segment, share.share = part;
  }
  return share;
}

TEST(Cameras, OppositeOnesSeeOneSegmentForEachObject) {
  std::size_t seen_by_both = 0;
  for (const std::uint64_t seed : {1U, 2U, 3U, 4U}) {
    const Rig scene = rig(seed, 2);
    const Segmentation result = segmented(scene.cloud);
    const std::uint32_t table = share_of(1, scene, result, 0, scene.truth.size()).segment;
    for (std::uint32_t object = 20; object <= 70; object += 10) {
      const Share left = share_of(object, scene, result, scene.first[0], scene.first[1]);
      const Share right = share_of(object, scene, result, scene.first[1], scene.first[2]);
      if (left.points < 200 || right.points < 200) continue;
      ++seen_by_both;
      EXPECT_EQ(left.segment, right.segment) << "object " << object << " of scene " << seed;
      EXPECT_NE(left.segment, table) << "object " << object << " of scene " << seed;
      EXPECT_GT(std::min(left.share, right.share), 0.8) << "object " << object << " of scene " << seed;
    }
  }
  EXPECT_GE(seen_by_both, 16U);
}

TEST(Cameras, TheResultDoesNotDependOnTheOrderOfTheirPoints) {
  const Rig scene = rig(5, 3);
  std::vector<std::uint32_t> order(scene.cloud.size());
  std::iota(order.begin(), order.end(), 0U);
  std::mt19937 random(7);
  for (std::size_t c = 0; c + 1 < scene.first.size(); ++c) {
    std::shuffle(order.begin() + static_cast<std::ptrdiff_t>(scene.first[c]),
                 order.begin() + static_cast<std::ptrdiff_t>(scene.first[c + 1]), random);
  }
  for (const Method method : {Method::kBorder, Method::kLambdaConvex}) {
    const Segmentation once = segmented(scene.cloud, {.method = method});
    const Segmentation again = segmented(test::permuted(scene.cloud, order), {.method = method, .threads = 3});
    EXPECT_EQ(once.tree, again.tree);
    for (std::size_t i = 0; i < order.size(); ++i) ASSERT_EQ(again.labels[i], once.labels[order[i]]);
  }
}

/// A thick board that lies in the plane z = 0, seen from above and from below.
Cloud board() {
  Cloud cloud = test::unorganized();
  test::add_patch(cloud, 0, 0, 0.05F, 0.3F, 0.003F, 0x808080);
  const std::uint32_t above = cloud.width;
  test::add_patch(cloud, 0, 0, -0.05F, 0.3F, 0.003F, 0x808080);
  cloud.view = View::of_cameras({{above, {0.15F, 0.15F, 1}}, {cloud.width - above, {0.15F, 0.15F, -1}}});
  return cloud;
}

TEST(Cameras, NormalsAreTurnedToTheCameraThatSawTheSurface) {
  const Cloud cloud = board();
  for (const bool edge_aware : {false, true}) {
    const test::TestFrame frame(cloud, Options{.voxel_resolution = 0.01});
    VoxelGrid grid;
    VoxelAdjacency adjacency;
    std::vector<Vec3> normals;
    ASSERT_TRUE(Voxelization().run(frame, grid).ok());
    ASSERT_TRUE(find_seeing_cameras(frame, grid).ok());
    ASSERT_TRUE(find_adjacency(frame, grid, adjacency).ok());
    ASSERT_TRUE((edge_aware ? EdgeAwareNormals().run(frame, grid, adjacency, normals)
                            : TwoRingNormals().run(frame, grid, adjacency, normals))
                    .ok());
    ASSERT_FALSE(normals.empty());
    for (std::size_t v = 0; v < grid.size(); ++v) {
      EXPECT_GT(grid.centroid[v].z * normals[v].z, 0.049) << "up above, down below";
    }
  }
}

TEST(Cameras, AVoxelWasSeenByTheCameraWithMostOfItsPointsOrElseTheNearest) {
  const auto camera_of = [](std::uint32_t first, std::uint32_t second, float first_height) {
    Cloud cloud = test::unorganized();
    for (std::uint32_t i = 0; i < first + second; ++i) test::add(cloud, 0.001F, 0.001F, 0.001F, 0);
    cloud.view = View::of_cameras({{first, {0, 0, first_height}}, {second, {0, 0, 2}}});
    const test::TestFrame frame(cloud, Options{.voxel_resolution = 0.01});
    VoxelGrid grid;
    EXPECT_TRUE(Voxelization().run(frame, grid).ok());
    EXPECT_TRUE(find_seeing_cameras(frame, grid).ok());
    EXPECT_EQ(grid.camera.size(), 1U);
    return grid.camera.empty() ? -1 : int{grid.camera[0]};
  };
  EXPECT_EQ(camera_of(3, 2, 9), 0);
  EXPECT_EQ(camera_of(2, 3, 1), 1);
  EXPECT_EQ(camera_of(2, 2, 9), 1);
  EXPECT_EQ(camera_of(2, 2, 1), 0);
  EXPECT_EQ(camera_of(2, 2, 2), 0) << "the first of two that are as near";
}

TEST(Cameras, RangesAreMeasuredFromTheCameraThatSawThePoint) {
  const Cloud cloud = board();
  const std::uint32_t above = cloud.view.cameras[0].points;
  // Every point is within 1.1 m of its own camera only if that is 1 m away.
  Cloud other = cloud;
  other.view.cameras[1].sensor.z() = -3;
  for (const unsigned threads : {1U, 2U}) {
    const Segmentation all = segmented(cloud, {.range_max = 1.1, .threads = threads});
    EXPECT_EQ(std::ranges::count(all.labels, 0U), 0);
    const Segmentation half = segmented(other, {.range_max = 1.1, .threads = threads});
    EXPECT_EQ(std::count(half.labels.begin(), half.labels.begin() + above, 0U), 0);
    EXPECT_EQ(std::count(half.labels.begin() + above, half.labels.end(), 0U), other.view.cameras[1].points);
  }
}

TEST(Cameras, ThePlaneUnderTheObjectsCanBeRemovedAndObjectsFollowed) {
  const Rig scene = rig(2, 2);
  const Segmentation result = segmented(scene.cloud, {.support_plane_distance = 0.01});
  ASSERT_TRUE(result.support_plane.has_value());
  EXPECT_GT(result.support_plane->normal.z(), 0.99);
  const auto tracking = track(segmented(scene.cloud), scene.cloud.view, {}, {});
  ASSERT_TRUE(tracking.ok()) << tracking.status();
  ASSERT_TRUE(tracking->state.plane.has_value());
  EXPECT_GT(tracking->state.plane->normal[2], 0.99);
}

TEST(Cameras, TheirNumberOfPointsMustBeThatOfTheCloud) {
  Cloud cloud = board();
  ++cloud.view.cameras[0].points;
  EXPECT_EQ(segment(cloud, {}).status().code(), absl::StatusCode::kInvalidArgument);
}

}  // namespace
}  // namespace segserve
