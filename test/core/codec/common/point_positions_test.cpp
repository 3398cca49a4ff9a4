// SPDX-License-Identifier: Apache-2.0
#include "core/codec/common/point_positions.hpp"

#include <Eigen/Dense>
#include <cmath>
#include <limits>
#include <span>
#include <vector>

#include "gmock/gmock.h"
#include "segserve/codec/unit_conversion.hpp"

namespace segserve::codec {
namespace {

using testing::ElementsAre;
using testing::FloatNear;
using testing::HasSubstr;
using testing::IsNan;

template <typename T>
LabeledCloud read(const std::array<std::vector<T>, 3>& axes, ScalarType type, const ReadOptions& options = {}) {
  LabeledCloud out;
  out.cloud.resize(axes[0].size(), false);
  out.cloud.width = static_cast<std::uint32_t>(axes[0].size());
  out.cloud.height = 1;
  std::array<Column, 3> columns;
  for (std::size_t i = 0; i < 3; ++i) columns[i] = {std::as_bytes(std::span(axes[i])).data(), sizeof(T), type};
  const StopToken never;
  StopCheck check(never);
  EXPECT_TRUE(read_positions(columns, type == ScalarType::kFloat32, {}, options, check, out).ok());
  return out;
}

TEST(PointPositions, CoordinatesFarAwayStayExact) {
  const std::array<std::vector<double>, 3> utm{
      std::vector{389425.001, 389425.002, 389425.0}, {5819321.0, 5819321.5, 5819320.75}, {112.0, 112.25, 112.0}};
  const LabeledCloud read_cloud = read(utm, ScalarType::kFloat64, {.keep_everything = true});
  EXPECT_EQ(read_cloud.placement.offset, Eigen::Vector3d(389425, 5819321, 112));
  EXPECT_THAT(read_cloud.cloud.x, ElementsAre(FloatNear(0.001F, 1e-9F), FloatNear(0.002F, 1e-9F), 0.0F));
  EXPECT_THAT(read_cloud.cloud.y, ElementsAre(0.0F, 0.5F, -0.25F));
  EXPECT_EQ(read_cloud.file_position[0], utm[0]);
  EXPECT_EQ(read_cloud.placement.to_file({0, 0.5, 0.25}), Eigen::Vector3d(389425, 5819321.5, 112.25));
}

TEST(PointPositions, FloatsThatAreCoarseFarAwayAreMentioned) {
  const auto line_at = [](float x, float step) {
    std::array<std::vector<float>, 3> axes;
    for (int i = 0; i < 50; ++i) {
      axes[0].push_back(x + step * static_cast<float>(i));
      axes[1].push_back(0);
      axes[2].push_back(0);
    }
    return read(axes, ScalarType::kFloat32);
  };
  const LabeledCloud coarse = line_at(5819321, 0.1F);
  ASSERT_EQ(coarse.warnings.size(), 1U);
  EXPECT_EQ(coarse.warnings[0].reason, WarningReason::kCoordinatesRounded);
  EXPECT_THAT(coarse.warnings[0].message, HasSubstr("rounded to 0.5 m"));
  EXPECT_EQ(line_at(5819321, 4).warnings.size(), 0U) << "fine beside the distance of the points";
  EXPECT_EQ(line_at(1000, 0.01F).warnings.size(), 0U);
}

TEST(PointPositions, AFewPointsFarAwayMoveNothing) {
  const LabeledCloud near = read<float>({{{0, 1, 2, 1e9F}, {0, 1, 2, 0}, {-1, 0, 1, 0}}}, ScalarType::kFloat32);
  EXPECT_TRUE(near.placement.is_identity());
  EXPECT_EQ(near.cloud.x[3], 1e9F);
}

TEST(PointPositions, NumbersForNoDataAreNoPoints) {
  const LabeledCloud heights =
      read<double>({{{389425, 389426, 389427, 389428}, {1, 2, 3, 4}, {112, -9999, -9999, 113}}}, ScalarType::kFloat64,
                   {.keep_everything = true});
  EXPECT_EQ(heights.placement.offset.z(), 113) << "the median of those that are measured";
  EXPECT_THAT(heights.cloud.z, ElementsAre(-1.0F, IsNan(), IsNan(), 0.0F));
  EXPECT_TRUE(std::isnan(heights.cloud.x[1]));
  EXPECT_THAT(heights.file_position[2], ElementsAre(112, -9999, -9999, 113)) << "outputs have what the file has";
  ASSERT_EQ(heights.warnings.size(), 1U);
  EXPECT_EQ(heights.warnings[0].reason, WarningReason::kPointsNotUsed);
  EXPECT_EQ(heights.warnings[0].message,
            "2 points have the coordinate -9999, which stands for no data, and are not used");
  constexpr float kLargest = std::numeric_limits<float>::max();
  const LabeledCloud whole =
      read<float>({{{0, -kLargest, 1}, {0, -kLargest, 1}, {0, -kLargest, 1}}}, ScalarType::kFloat32);
  EXPECT_TRUE(std::isnan(whole.cloud.x[1]));
  ASSERT_EQ(whole.warnings.size(), 1U);
  EXPECT_THAT(whole.warnings[0].message, HasSubstr("1 point has the coordinate -3.40282347e+38"));
}

TEST(PointPositions, ManyZerosFarFromAllOthersAreNoPoints) {
  const auto grid = [](float x, int zeros) {
    std::array<std::vector<float>, 3> axes;
    for (int i = 0; i < 400; ++i) {
      axes[0].push_back(x + 0.1F * static_cast<float>(i % 20));
      axes[1].push_back(0.1F * static_cast<float>(i / 20));
      axes[2].push_back(0);
    }
    for (auto& axis : axes) axis.resize(axis.size() + static_cast<std::size_t>(zeros), 0);
    return read(axes, ScalarType::kFloat32);
  };
  const LabeledCloud filled = grid(3, 30);
  EXPECT_TRUE(std::isnan(filled.cloud.x[400]));
  ASSERT_EQ(filled.warnings.size(), 1U);
  EXPECT_EQ(filled.warnings[0].message, "30 points at (0, 0, 0), far from all others, are no measurements");
  EXPECT_TRUE(grid(0, 30).warnings.empty()) << "on a surface they may be points";
  EXPECT_TRUE(grid(3, 5).warnings.empty()) << "few";
}

TEST(PointPositions, TheSameNumbersAmongOthersArePoints) {
  // A mine in millimeters, and a cloud of which nothing else is known.
  const LabeledCloud mine = read<float>({{{0, 1, 2}, {0, 1, 2}, {-9000, -9999, -12000}}}, ScalarType::kFloat32);
  EXPECT_EQ(mine.cloud.z[1] - mine.cloud.z[0], -999);
  const LabeledCloud all = read<float>({{{-9999, -9999}, {0, 1}, {0, 1}}}, ScalarType::kFloat32);
  EXPECT_TRUE(std::isfinite(all.cloud.x[0]));
  EXPECT_TRUE(mine.warnings.empty() && all.warnings.empty());
}

TEST(PointPositions, NumbersBeyondTheEarthMoveNothing) {
  EXPECT_TRUE(read<float>({{{1e30F}, {0}, {0}}}, ScalarType::kFloat32).placement.is_identity());
}

TEST(PointPositions, DoublesThatNoFloatHoldsAreMentioned) {
  const std::array<std::vector<double>, 3> axes{std::vector<double>{1e300, 1, NAN}, {-1e300, 2, 0}, {0, 3, 0}};
  const LabeledCloud cloud = read(axes, ScalarType::kFloat64);
  ASSERT_EQ(cloud.warnings.size(), 1U);
  EXPECT_EQ(cloud.warnings[0].reason, WarningReason::kPointsNotUsed);
  EXPECT_EQ(cloud.warnings[0].message, "1 point beyond 3e38 m, which no float holds, is not used");
}

TEST(PointPositions, UnitsBecomeMeters) {
  const std::array<std::vector<std::int16_t>, 3> axes{std::vector<std::int16_t>{1000, 2000}, {0, 500}, {-250, 0}};
  const LabeledCloud millimeters =
      read(axes, ScalarType::kInt16, {.unit = LengthUnit::kMillimeter, .keep_everything = true});
  EXPECT_THAT(millimeters.cloud.x, ElementsAre(1.0F, 2.0F));
  EXPECT_THAT(millimeters.cloud.z, ElementsAre(-0.25F, 0.0F));
  EXPECT_THAT(millimeters.file_position[0], ElementsAre(1000.0, 2000.0));
  EXPECT_FLOAT_EQ(read(axes, ScalarType::kInt16, {.unit = LengthUnit::kInch}).cloud.x[0], 25.4F);
  EXPECT_FLOAT_EQ(read(axes, ScalarType::kInt16, {.unit = LengthUnit::kFoot}).placement.meters_per_unit(), 0.3048F);
  EXPECT_TRUE(read<float>({{{1}, {2}, {3}}}, ScalarType::kFloat32, {.keep_everything = true}).file_position[0].empty());
}

TEST(PointPositions, TheSpacingTellsTheUnit) {
  std::array<std::vector<float>, 3> grid;
  for (int i = 0; i < 400; ++i) {
    grid[0].push_back(static_cast<float>(i % 20) * 5.5F);
    grid[1].push_back(static_cast<float>(i / 20) * 5.5F);
    grid[2].push_back(-10.5F);
  }
  const LabeledCloud millimeters = read(grid, ScalarType::kFloat32, {.unit = LengthUnit::kAuto});
  EXPECT_EQ(millimeters.placement.meters_per_unit(), 0.001);
  ASSERT_EQ(millimeters.warnings.size(), 1U);
  EXPECT_EQ(millimeters.warnings[0].reason, WarningReason::kUnitGuessed);
  EXPECT_THAT(millimeters.warnings[0].message,
              HasSubstr("millimeters, because neighboring points are 5.5 units apart"));
  for (auto& axis : grid) {
    for (float& v : axis) v *= 0.001F;
  }
  EXPECT_EQ(read(grid, ScalarType::kFloat32, {.unit = LengthUnit::kAuto}).placement.meters_per_unit(), 1);
}

TEST(PointPositions, ACloudInAnotherUnitIsConverted) {
  Cloud cloud;
  cloud.x = {100, 200}, cloud.y = {0, 0}, cloud.z = {50, 60}, cloud.rgb = {1, 2};
  cloud.width = 2, cloud.height = 1;
  const auto meters = to_meters(cloud, {.view = View::world(0, 0, 1), .unit = LengthUnit::kCentimeter});
  ASSERT_TRUE(meters.ok());
  EXPECT_THAT(meters->cloud.x, ElementsAre(1.0F, 2.0F));
  EXPECT_EQ(meters->cloud.view, View::world(0, 0, 1)) << "lengths outside the payload are in meters";
  EXPECT_THAT(meters->cloud.rgb, ElementsAre(1, 2));
}

TEST(Placement, CarriesOptionsToTheCloudAndResultsBack) {
  const Placement placement{{0.001, -0.001, -0.001}, {1000, 0, 2000}};
  Options options;
  options.crop_min_y = -0.5, options.crop_max_y = 0.25, options.crop_min_x = 1.5;
  const Options moved = to_cloud(placement, options);
  EXPECT_DOUBLE_EQ(*moved.crop_min_y, -0.25);
  EXPECT_DOUBLE_EQ(*moved.crop_max_y, 0.5);
  EXPECT_DOUBLE_EQ(*moved.crop_min_x, 0.5);
  EXPECT_FALSE(moved.crop_max_x);

  Segmentation segmentation;
  segmentation.statistics.resize(1);
  SegmentStatistics& segment = segmentation.statistics[0];
  segment.centroid = {1, 2, 3};
  segment.box.half_extents = {0.1, 0.2, 0.3};
  segment.normal = Eigen::Vector3d(0, 0.6, 0.8);
  segmentation.support_plane = SupportPlane{{0, 0, 1}, 0.5, 10};
  to_file(placement, segmentation);
  EXPECT_TRUE(segment.centroid.isApprox(Eigen::Vector3d(2000, -2000, -1000)));
  EXPECT_TRUE(segment.box.half_extents.isApprox(Eigen::Vector3d(100, 200, 300)));
  EXPECT_NEAR(segment.box.axes.determinant(), 1, 1e-12);
  EXPECT_EQ(segment.normal, Eigen::Vector3d(0, -0.6, -0.8));
  const SupportPlane& plane = *segmentation.support_plane;
  const Eigen::Vector3d on_plane = placement.to_file({7, 8, 0.5});
  EXPECT_NEAR(plane.normal.dot(on_plane), plane.offset, 1e-9);

  const View view = View::world(0, 0, 1);
  EXPECT_TRUE(to_cloud(placement, to_file(placement, view)).sensor->isApprox(*view.sensor));
}

}  // namespace
}  // namespace segserve::codec
