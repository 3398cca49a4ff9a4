// SPDX-License-Identifier: Apache-2.0
#include "core/voxels/point_selection.hpp"

#include <gtest/gtest.h>

#include <array>
#include <cmath>

#include "core/lab/synth/scene.hpp"
#include "core/voxels/simd/voxel_kernels.hpp"
#include "core/voxels/voxel_key.hpp"
#include "segserve/segment.hpp"
#include "test/core/support/clouds.hpp"

namespace segserve {
namespace {

bool selects(const Options& options, float x, float y, float z, const View& view = View::camera()) {
  const PointSelection selection(options, view);
  const CellInput in{.x = &x,
                     .y = &y,
                     .z = &z,
                     .camera = false,
                     .cells_per_meter = 1,
                     .units_per_meter = 1,
                     .elongation_depth = 0,
                     .elongation_depth_logarithm = 0,
                     .selection = &selection.limits()};
  std::array<std::uint64_t, 8> keys{};
  std::array<std::int32_t, 8> fixed_x{}, fixed_y{}, fixed_z{};
  voxel_kernels().find_cells(in, 1, {keys.data(), fixed_x.data(), fixed_y.data(), fixed_z.data()});
  EXPECT_EQ(selection.selects(x, y, z), keys[0] != kNoKey) << "the kernel selects the same points";
  return keys[0] != kNoKey;
}

TEST(PointSelection, SelectsEverythingUnlessOptionsSayOtherwise) {
  EXPECT_TRUE(PointSelection().all());
  EXPECT_TRUE(PointSelection({}, View::world()).all());
  EXPECT_FALSE(PointSelection({.crop_max_y = 1}, View::world()).all());
  EXPECT_FALSE(PointSelection({.range_min = 0.5}, View::camera()).all());
}

TEST(PointSelection, ACropBoxIsClosedAndItsUnsetSidesAreOpen) {
  const Options options{.crop_min_x = -0.25, .crop_max_x = 0.5, .crop_min_z = 1};
  EXPECT_TRUE(selects(options, -0.25F, 1e6F, 1));
  EXPECT_TRUE(selects(options, 0.5F, -1e6F, 1e6F));
  EXPECT_FALSE(selects(options, std::nextafter(-0.25F, -1.0F), 0, 2));
  EXPECT_FALSE(selects(options, std::nextafter(0.5F, 1.0F), 0, 2));
  EXPECT_FALSE(selects(options, 0, 0, std::nextafter(1.0F, 0.0F)));
}

TEST(PointSelection, LimitsAreNotRoundedToTheCoordinates) {
  EXPECT_GT(0.1F, 0.1);
  EXPECT_FALSE(selects({.crop_max_x = 0.1}, 0.1F, 0, 1));
  EXPECT_TRUE(selects({.crop_max_x = double{0.1F}}, 0.1F, 0, 1));
}

TEST(PointSelection, TheRangeIsMeasuredFromTheSensor) {
  const Options options{.range_min = 3, .range_max = 5};
  EXPECT_TRUE(selects(options, 0, 3, 4));
  EXPECT_TRUE(selects(options, 0, 0, 3));
  EXPECT_FALSE(selects(options, 0, 0, 2.999F));
  EXPECT_FALSE(selects(options, 0, 3, 4.001F));
  EXPECT_TRUE(selects(options, 10, 3, 4, View::world(10, 0, 0)));
  EXPECT_FALSE(selects(options, 10, 3, 4, View::camera()));
}

/// The cloud with NaN in place of the points that `keep` refuses.
template <typename Keep>
Cloud without(Cloud cloud, Keep&& keep) {
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    if (!keep(cloud.x[i], cloud.y[i], cloud.z[i])) cloud.x[i] = NAN;
  }
  return cloud;
}

/// Expects that points that are left out have no influence: labels, tree and counts are those of the cloud without
/// them.
void expect_as_if_not_finite(const Cloud& cloud, const Options& options, const Cloud& rest) {
  Options plain = options;
  plain.crop_min_x = plain.crop_max_x = plain.crop_min_y = plain.crop_max_y = plain.crop_min_z = plain.crop_max_z = {};
  plain.range_min = plain.range_max = {};
  const Segmentation whole = *segment(cloud, plain);
  const Segmentation expected = *segment(rest, plain);
  ASSERT_GT(expected.segments, 1U) << "the part must have something to segment";
  ASSERT_LT(expected.finite_points, whole.finite_points);
  for (const std::uint32_t threads : {1U, 3U}) {
    Options asked = options;
    asked.threads = threads;
    const Segmentation part = *segment(cloud, asked);
    EXPECT_EQ(part.labels, expected.labels);
    EXPECT_EQ(part.supervoxels, expected.supervoxels);
    EXPECT_TRUE(part.tree == expected.tree);
    EXPECT_EQ(part.segments, expected.segments);
    EXPECT_EQ(part.voxels, expected.voxels);
    EXPECT_EQ(part.segmented_points, expected.finite_points);
    EXPECT_EQ(part.finite_points, whole.finite_points) << "points that are left out are finite";
  }
}

TEST(PointsLeftOut, ByACropBoxAroundATabletopHaveNoInfluence) {
  const Cloud cloud = synth::make_tabletop({.seed = 3, .width = 320, .height = 240})->cloud;
  const Cloud rest = without(
      cloud, [](float x, float y, float z) { return x >= -0.2 && x <= 0.3 && y <= 0.25 && z >= 0.5 && z <= 1.15; });
  expect_as_if_not_finite(
      cloud, {.crop_min_x = -0.2, .crop_max_x = 0.3, .crop_max_y = 0.25, .crop_min_z = 0.5, .crop_max_z = 1.15}, rest);
}

TEST(PointsLeftOut, ByTheRangeFromACameraHaveNoInfluence) {
  const Cloud cloud = synth::make_tabletop({.seed = 3, .width = 320, .height = 240})->cloud;
  const Cloud rest = without(cloud, [](double x, double y, double z) {
    const double squared = x * x + y * y + z * z;
    return squared >= 0.8 * 0.8 && squared <= 1.1 * 1.1;
  });
  for (const Method method : {Method::kBorder, Method::kLambdaConvex}) {
    expect_as_if_not_finite(cloud, {.method = method, .range_min = 0.8, .range_max = 1.1}, rest);
  }
}

TEST(PointsLeftOut, ByBoxAndRangeInARoomHaveNoInfluence) {
  const Cloud cloud = synth::make_fused_room({.seed = 3, .points = 60000})->cloud;
  ASSERT_TRUE(cloud.view.sensor.has_value());
  const Eigen::Vector3f sensor = *cloud.view.sensor;
  const Cloud rest = without(cloud, [&](double x, double y, double z) {
    const double dx = x - sensor[0], dy = y - sensor[1], dz = z - sensor[2];
    return z >= 0.05 && dx * dx + dy * dy + dz * dz <= 1.5 * 1.5;
  });
  expect_as_if_not_finite(
      cloud, {.voxel_resolution = 0.03, .seed_resolution = 0.15, .crop_min_z = 0.05, .range_max = 1.5}, rest);
}

TEST(PointsLeftOut, NeedNeitherFitTheGridNorBeInFrontOfTheCamera) {
  Cloud cloud = test::unorganized(View::camera());
  test::add_patch(cloud, -0.1F, -0.1F, 1, 0.2F, 0.005F, 0x808080);
  const std::size_t good = cloud.size();
  for (std::size_t i = 0; i < good / 10; ++i) test::add(cloud, 0, 0, -1, 0);
  test::add(cloud, 1e30F, 0, 1, 0);
  EXPECT_FALSE(segment(cloud, {}).ok());
  const absl::StatusOr<Segmentation> part = segment(cloud, {.crop_min_z = 0.1, .range_max = 10});
  ASSERT_TRUE(part.ok()) << part.status();
  EXPECT_EQ(part->segmented_points, good);
  EXPECT_EQ(part->finite_points, cloud.size());
}

TEST(PointsLeftOut, MayBeAllOfThem) {
  const Cloud cloud = test::random_cloud(1000, 0.5F, 1, View::camera());
  const Segmentation none = *segment(cloud, {.crop_min_x = 5});
  EXPECT_EQ(none.segments, 0U);
  EXPECT_EQ(none.segmented_points, 0U);
  EXPECT_EQ(none.finite_points, 1000U);
  EXPECT_EQ(std::ranges::count(none.labels, 0U), 1000);
}

}  // namespace
}  // namespace segserve
