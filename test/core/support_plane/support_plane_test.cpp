// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <numeric>
#include <random>

#include "core/lab/synth/scene.hpp"
#include "segserve/codec/cloud_file.hpp"
#include "segserve/segment.hpp"
#include "test/core/support/clouds.hpp"

namespace segserve {
namespace {

// Labels in synthetic scenes and in OSD's ground truth.
constexpr std::uint32_t kSupport = 1;
constexpr std::uint32_t kFirstObject = 10;

Options removal(double distance = 0.01) { return {.support_plane_distance = distance}; }

/// The share of the points that has label 0, for several kinds of points.
struct Removed {
  double support = 0;
  double objects = 0;
  double high_objects = 0;  // points of objects more than 1.2 distances above the plane
  double other = 0;         // points of neither support nor objects
};

Removed removed(const CloudView& cloud, const std::vector<std::uint32_t>& truth, const Segmentation& s,
                double distance) {
  struct Share {
    double removed = 0, all = 0;
    double value() const { return all > 0 ? removed / all : 0; }
  };
  Share support, objects, high, other;
  for (std::size_t i = 0; i < truth.size(); ++i) {
    if (truth[i] == 0 || !is_finite(cloud.x[i], cloud.y[i], cloud.z[i])) continue;
    const bool object = truth[i] >= kFirstObject;
    Share& share = truth[i] == kSupport ? support : object ? objects : other;
    const double gone = s.labels[i] == 0 ? 1 : 0;
    share.removed += gone, share.all += 1;
    const double height =
        s.support_plane->normal.dot(Eigen::Vector3d(cloud.x[i], cloud.y[i], cloud.z[i])) - s.support_plane->offset;
    const double scale = cloud.view.kind == ViewKind::kCamera ? cloud.z[i] : 1;
    if (object && height > 1.2 * distance * scale) high.removed += gone, high.all += 1;
  }
  return {support.value(), objects.value(), high.value(), other.value()};
}

class Tabletop : public testing::TestWithParam<std::uint64_t> {};

TEST_P(Tabletop, LosesItsTableAndKeepsItsObjects) {
  for (const bool in_a_room : {false, true}) {
    const synth::SyntheticScene scene = *synth::make_tabletop({.seed = GetParam(), .all_finite = in_a_room});
    const Segmentation s = *segment(scene.cloud, removal());
    const Removed r = removed(scene.cloud, scene.label, s, 0.01);
    EXPECT_GE(r.support, 0.995);
    EXPECT_LE(r.objects, 0.13) << "the feet of objects and flat objects are within the distance";
    EXPECT_LE(r.high_objects, 0.002);
    EXPECT_LE(r.other, 0.004);
    EXPECT_NEAR(s.support_plane->normal.norm(), 1, 1e-12);
    EXPECT_LT(s.support_plane->normal.z(), 0) << "towards the camera";
  }
}

INSTANTIATE_TEST_SUITE_P(Seeds, Tabletop, testing::Range<std::uint64_t>(1, 7));

TEST(SupportPlane, IsTheTableOfARoomThoughItsWallsAreLarger) {
  for (const std::uint64_t seed : {1U, 3U, 4U}) {
    const synth::SyntheticScene scene = *synth::make_tabletop({.seed = seed, .distance = 2, .all_finite = true});
    const Removed r = removed(scene.cloud, scene.label, *segment(scene.cloud, removal()), 0.01);
    EXPECT_GE(r.support, 0.99);
    EXPECT_LE(r.high_objects, 0.01);
    EXPECT_LE(r.other, 0.005);
  }
}

TEST(SupportPlane, IsTheLargestBelowACameraThatLooksStraightDown) {
  Cloud cloud = test::unorganized(View::camera());
  test::add_patch(cloud, -0.3F, -0.3F, 1, 0.6F, 0.005F, 0x808080);
  test::add_patch(cloud, -0.1F, -0.1F, 0.9F, 0.2F, 0.005F, 0xff0000);
  const Segmentation s = *segment(cloud, removal());
  EXPECT_NEAR(s.support_plane->normal.z(), -1, 1e-6);
  EXPECT_NEAR(s.support_plane->offset, -1, 1e-4);
  EXPECT_EQ(s.segments, 1U);
}

TEST(SupportPlane, IsTheTableOfRealScenes) {
  const std::filesystem::path folder = std::filesystem::path(SEGSERVE_DATA_DIR) / "osd/learn";
  if (!std::filesystem::exists(folder)) GTEST_SKIP() << "no OSD scenes in " << folder;
  double objects = 0, scenes = 0;
  for (int i = 0; i < 45; ++i) {
    const auto scene = codec::load_cloud(folder / ("learn" + std::to_string(i) + ".pcd"));
    ASSERT_TRUE(scene.ok()) << scene.status();
    const Segmentation s = *segment(scene->cloud, removal());
    const Removed r = removed(scene->cloud, scene->label, s, 0.01);
    EXPECT_GE(r.support, 0.99) << i;
    EXPECT_LE(r.objects, 0.08) << i;
    EXPECT_LE(r.high_objects, 0.002) << i;
    objects += r.objects, scenes += 1;
  }
  EXPECT_LE(objects / scenes, 0.02);
}

TEST(SupportPlane, IsTheFloorOfARoom) {
  synth::SyntheticScene scene = *synth::make_fused_room({.seed = 2, .points = 150000});
  Options options = removal(0.02);
  options.voxel_resolution = 0.02;
  options.seed_resolution = 0.1;
  for (const bool with_sensor : {true, false}) {
    if (!with_sensor) scene.cloud.view = View::world();
    const Segmentation s = *segment(scene.cloud, options);
    EXPECT_GT(s.support_plane->normal.z(), 0.999);
    EXPECT_NEAR(s.support_plane->offset, 0, 0.005);
    const Removed r = removed(scene.cloud, scene.label, s, 0.02);
    EXPECT_GE(r.support, 0.97);
    EXPECT_LE(r.high_objects, 0.002);
    EXPECT_LE(r.other, 0.02);
  }
}

/// A small tabletop for the tests of what the removal does to everything else.
const Cloud& small_tabletop() {
  static const Cloud cloud = synth::make_tabletop({.seed = 3, .width = 320, .height = 240})->cloud;
  return cloud;
}

TEST(SupportPlane, IsRemovedAsIfItsPointsWereNotFinite) {
  Cloud room = synth::make_fused_room({.seed = 3, .points = 60000})->cloud;
  Cloud unseen_room = room;
  unseen_room.view = View::world();
  for (const Cloud& cloud : {small_tabletop(), room, unseen_room}) {
    for (const Method method : {Method::kBorder, Method::kLambda}) {
      Options options{.method = method, .voxel_resolution = 0.02, .seed_resolution = 0.1};
      Options removing = options;
      removing.support_plane_distance = 0.015;
      const Segmentation s = *segment(cloud, removing);
      ASSERT_GT(s.support_plane->points, 0U);
      Cloud rest = cloud;
      for (std::size_t i = 0; i < rest.size(); ++i) {
        if (s.labels[i] == 0) rest.x[i] = NAN;
      }
      const Segmentation expected = *segment(rest, options);
      EXPECT_EQ(s.labels, expected.labels);
      EXPECT_EQ(s.supervoxels, expected.supervoxels);
      EXPECT_TRUE(s.tree == expected.tree);
      EXPECT_EQ(s.segments, expected.segments);
      EXPECT_EQ(s.segmented_points, expected.finite_points);
      EXPECT_EQ(s.segmented_points + s.support_plane->points, s.finite_points);
    }
  }
}

TEST(SupportPlane, DependsNeitherOnTheOrderOfThePointsNorOnThreads) {
  const Segmentation s = *segment(small_tabletop(), removal());
  Options options = removal();
  options.threads = 3;
  const Segmentation threaded = *segment(small_tabletop(), options);
  EXPECT_EQ(threaded.labels, s.labels);
  EXPECT_EQ(threaded.support_plane, s.support_plane);
  std::vector<std::uint32_t> order(small_tabletop().size());
  std::iota(order.begin(), order.end(), 0U);
  std::ranges::shuffle(order, std::mt19937(3));
  const Segmentation p = *segment(test::permuted(small_tabletop(), order), removal());
  for (std::size_t i = 0; i < order.size(); ++i) ASSERT_EQ(p.labels[i], s.labels[order[i]]);
  EXPECT_EQ(p.support_plane, s.support_plane);
}

/// A floor, a larger wall behind it, and the tops of a low and a high box on the floor. z is up, and points are 5 mm
/// apart.
Cloud floor_and_wall(const View& view) {
  Cloud cloud = test::unorganized(view);
  test::add_patch(cloud, 0, 0, 0.3F, 1, 0.005F, 0x808080);
  for (float x = 0; x < 1; x += 0.005F) {
    for (float z = 0.3F; z < 2; z += 0.005F) test::add(cloud, x, 1, z, 0x909090);
  }
  test::add_patch(cloud, 0.2F, 0.2F, 0.33F, 0.1F, 0.005F, 0xff0000);
  test::add_patch(cloud, 0.6F, 0.6F, 0.40F, 0.1F, 0.005F, 0x00ff00);
  return cloud;
}

TEST(SupportPlane, FacesUpInAWorldViewThoughAWallIsLarger) {
  for (const View& view : {View::world(0.5F, -1, 1.5F), View::world()}) {
    const Segmentation s = *segment(floor_and_wall(view), removal());
    EXPECT_NEAR(s.support_plane->normal.z(), 1, 1e-6);
    EXPECT_NEAR(s.support_plane->offset, 0.3, 1e-4);
    EXPECT_NEAR(static_cast<double>(s.support_plane->points), 40000, 600) << "the foot of the wall belongs to it";
    EXPECT_TRUE(std::all_of(s.labels.end() - 800, s.labels.end(), [](std::uint32_t label) { return label > 0; }))
        << "the boxes, of 400 points each, do not belong to it";
  }
}

TEST(SupportPlane, IsNoCeiling) {
  Cloud ceiling = test::unorganized(View::world(0.5F, 0.5F, 0));
  test::add_patch(ceiling, 0, 0, 2, 1, 0.005F, 0x808080);
  const Segmentation s = *segment(ceiling, removal());
  EXPECT_EQ(s.support_plane, SupportPlane{});
  EXPECT_EQ(s.segmented_points, ceiling.size());
}

TEST(SupportPlane, DoesNotTakePointsBelowIt) {
  Cloud cloud = test::unorganized(View::world(0.5F, 0.5F, 5));
  test::add_patch(cloud, 0, 0, 1, 1, 0.005F, 0x808080);
  test::add_patch(cloud, 1.2F, 0, 0.5F, 0.3F, 0.005F, 0x808080);  // a stool beside the table
  const Segmentation s = *segment(cloud, removal());
  EXPECT_EQ(s.support_plane->points, 40000U);
  EXPECT_EQ(s.segmented_points, cloud.size() - 40000);
  EXPECT_EQ(s.segments, 1U);
}

TEST(SupportPlane, IsNoneInACloudWithoutPlanes) {
  const Cloud cloud = test::random_cloud(20000, 0.5F, 1, View::camera());
  const Segmentation with = *segment(cloud, removal()), without = *segment(cloud, {});
  ASSERT_TRUE(with.support_plane.has_value());
  EXPECT_EQ(*with.support_plane, SupportPlane{});
  EXPECT_EQ(with.labels, without.labels);
  EXPECT_FALSE(without.support_plane.has_value());
}

TEST(SupportPlane, MayBeTheWholeCloud) {
  Cloud cloud = test::unorganized(View::world(0.5F, 0.5F, 5));
  test::add_patch(cloud, 0, 0, 1, 0.5F, 0.005F, 0x808080);
  const Segmentation s = *segment(cloud, removal());
  EXPECT_EQ(s.support_plane->points, cloud.size());
  EXPECT_EQ(s.segments, 0U);
  EXPECT_EQ(s.tree.leaf_count(), 0U);
}

TEST(SupportPlane, IsNoneWithoutAnyPoint) {
  Cloud cloud = test::unorganized();
  test::add(cloud, NAN, 0, 0, 0);
  EXPECT_EQ(segment(cloud, removal())->support_plane, SupportPlane{});
  test::add(cloud, 1, 2, 3, 0);
  EXPECT_EQ(segment(cloud, removal())->support_plane, SupportPlane{}) << "one point has no normal";
}

TEST(SupportPlane, IsAsExactFarFromTheOrigin) {
  Cloud near = test::unorganized(View::world(0.5F, 0.5F, 2)), far = test::unorganized(View::world(512.5F, 512.5F, 258));
  for (Cloud* cloud : {&near, &far}) {
    const float shift = cloud == &far ? 512 : 0;
    test::add_patch(*cloud, shift, shift, shift / 2, 1, 0.0078125F, 0x808080);
  }
  const SupportPlane there = *segment(far, removal())->support_plane;
  EXPECT_EQ(there.points, segment(near, removal())->support_plane->points);
  EXPECT_NEAR(there.normal.z(), 1, 1e-12);
  EXPECT_NEAR(there.offset, 256, 1e-9);
}

}  // namespace
}  // namespace segserve
