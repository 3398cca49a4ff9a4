// SPDX-License-Identifier: Apache-2.0
#include "segserve/segment_statistics.hpp"

#include <Eigen/LU>
#include <algorithm>
#include <atomic>
#include <bit>
#include <cmath>
#include <limits>
#include <numeric>
#include <random>
#include <string>

#include "core/lab/synth/scene.hpp"
#include "gmock/gmock.h"
#include "segserve/segment.hpp"
#include "test/core/support/clouds.hpp"

namespace segserve {
namespace {

using Eigen::Vector3d;

constexpr float kNan = std::numeric_limits<float>::quiet_NaN();

Vector3d point(const Cloud& cloud, std::size_t i) { return {cloud.x[i], cloud.y[i], cloud.z[i]}; }

void add(Cloud& cloud, const Vector3d& p, std::uint32_t rgb = 0) {
  test::add(cloud, static_cast<float>(p.x()), static_cast<float>(p.y()), static_cast<float>(p.z()), rgb);
}

SegmentStatistics describe_all(const Cloud& cloud) {
  return describe_segments(cloud, std::vector<std::uint32_t>(cloud.size(), 1), 1).value().at(0);
}

void expect_near(const Vector3d& got, const Vector3d& expected, double tolerance) {
  EXPECT_LE((got - expected).norm(), tolerance) << got.transpose();
}

/// How far the point is outside the box, meters.
double beyond(const OrientedBox& box, const Vector3d& p) {
  return ((box.axes.transpose() * (p - box.center)).cwiseAbs() - box.half_extents).maxCoeff();
}

void expect_valid(const OrientedBox& box) {
  EXPECT_TRUE((box.axes.transpose() * box.axes).isIdentity(1e-13));
  EXPECT_NEAR(box.axes.determinant(), 1, 1e-13) << "right-handed";
  EXPECT_GE(box.half_extents.minCoeff(), 0);
}

/// A solid box of 1.2 m x 0.6 m x 0.2 m, sampled evenly up to its corners.
struct Solid {
  Vector3d center{0.3, -2, 5};
  Eigen::Matrix3d axes{{2.0 / 3, -2.0 / 3, -1.0 / 3}, {1.0 / 3, 2.0 / 3, -2.0 / 3}, {2.0 / 3, 1.0 / 3, 2.0 / 3}};
  Vector3d half{0.6, 0.3, 0.1};

  Cloud cloud() const {
    Cloud cloud = test::unorganized();
    for (int i = -12; i <= 12; ++i) {
      for (int j = -6; j <= 6; ++j) {
        for (int k = -2; k <= 2; ++k) {
          const Vector3d p = center + axes * half.cwiseProduct(Vector3d(i / 12.0, j / 6.0, k / 2.0));
          add(cloud, p, pack_rgb(200, static_cast<std::uint8_t>(100 + k), static_cast<std::uint8_t>(50 + i)));
        }
      }
    }
    return cloud;
  }
};

TEST(SegmentStatistics, OfARotatedBoxAreItsOwn) {
  const Solid solid;
  const Cloud cloud = solid.cloud();
  const SegmentStatistics got = describe_all(cloud);
  EXPECT_EQ(got.points, cloud.size());
  expect_near(got.centroid, solid.center, 1e-6);
  expect_near(got.box.center, solid.center, 1e-6);
  expect_near(got.box.half_extents, solid.half, 1e-6);
  expect_near(got.box.axes.col(0), solid.axes.col(0), 1e-6);
  expect_near(got.box.axes.col(1), -solid.axes.col(1), 1e-6);  // the largest component of an axis is positive ..
  expect_near(got.box.axes.col(2), -solid.axes.col(2), 1e-6);  // .. and the third makes them right-handed
  expect_valid(got.box);
  ASSERT_TRUE(got.color);
  expect_near(*got.color, {200, 100, 50}, 1e-12);
  EXPECT_FALSE(got.normal);
}

TEST(SegmentStatistics, AreOfEachSegmentAndOfNoPointWithoutOne) {
  Cloud cloud = test::unorganized();
  for (int i = 0; i < 4; ++i) add(cloud, {0.25 * i, 0, 1}, pack_rgb(10, 20, 30));
  add(cloud, {100, 100, 100}, 0xffffff);
  add(cloud, {kNan, 0, 0}, 0xffffff);
  add(cloud, {5, 6, 7}, pack_rgb(1, 2, 3));
  add(cloud, {8, 8, 8}, 0xffffff);
  const std::vector<std::uint32_t> labels{1, 1, 1, 1, 0, 0, 2, 3};
  const auto got = describe_segments(cloud, labels, 2).value();
  ASSERT_EQ(got.size(), 2U);
  EXPECT_EQ(got[0].points, 4U);
  expect_near(got[0].centroid, {0.375, 0, 1}, 1e-9);
  expect_near(got[0].box.half_extents, {0.375, 0, 0}, 1e-9);
  EXPECT_EQ(got[0].color, (Vector3d{10, 20, 30}));
  EXPECT_EQ(got[1].points, 1U);
  EXPECT_EQ(got[1].centroid, (Vector3d{5, 6, 7}));
  EXPECT_EQ(got[1].color, (Vector3d{1, 2, 3}));
}

TEST(SegmentStatistics, OfDegenerateSegmentsHaveABox) {
  Cloud one = test::unorganized(), same = test::unorganized(), line = test::unorganized(), plane = test::unorganized();
  add(one, {1, 2, 3});
  for (int i = 0; i < 7; ++i) add(same, {-1, 0.1, 1e-20});
  for (int i = 0; i < 9; ++i) add(line, {1 + 0.5 * i, 2 - 0.25 * i, 0.125 * i});
  for (int i = 0; i < 100; ++i) add(plane, {0.5 * (i % 10), 0.25 * (i / 10), 3});  // NOLINT(bugprone-integer-division)

  const SegmentStatistics of_one = describe_all(one), of_same = describe_all(same);
  EXPECT_EQ(of_one.box, (OrientedBox{.center = {1, 2, 3}}));
  EXPECT_EQ(of_one.centroid, (Vector3d{1, 2, 3}));
  EXPECT_EQ(of_same.points, 7U);
  EXPECT_EQ(of_same.box.center, point(same, 0));
  EXPECT_EQ(of_same.box.half_extents, Vector3d::Zero());

  const SegmentStatistics of_line = describe_all(line);
  expect_valid(of_line.box);
  expect_near(of_line.box.axes.col(0), Vector3d(4, -2, 1).normalized(), 1e-7);
  expect_near(of_line.box.half_extents, {0.5 * Vector3d(4, -2, 1).norm(), 0, 0}, 1e-6);

  const SegmentStatistics of_plane = describe_all(plane);
  expect_valid(of_plane.box);
  expect_near(of_plane.box.half_extents, {2.25, 1.125, 0}, 1e-9);
  expect_near(of_plane.box.axes.col(2), {0, 0, 1}, 1e-9);
}

TEST(SegmentStatistics, HoldAtAnyScaleAndPlace) {
  const Solid solid;
  for (const double scale : {1e-6, 1e-3, 1e3, 1e6, 1e30}) {
    Cloud cloud = solid.cloud();
    for (auto* plane : {&cloud.x, &cloud.y, &cloud.z}) {
      for (float& v : *plane) v *= static_cast<float>(scale);
    }
    const SegmentStatistics got = describe_all(cloud);
    expect_near(got.box.half_extents, scale * solid.half, 1e-6 * scale);
    expect_near(got.box.axes.col(0), solid.axes.col(0), 1e-6);
    expect_near(got.centroid, scale * solid.center, 1e-6 * scale);
  }
}

TEST(SegmentStatistics, AreUnsetWhereThereIsNothingToTell) {
  Cloud cloud = test::random_cloud(100, 1, 2, View::world());
  cloud.rgb.clear();
  std::vector<std::uint32_t> labels(100, 1);
  labels[7] = 3;
  const auto got = describe_segments(cloud, labels, 3).value();
  EXPECT_FALSE(got[0].color);
  EXPECT_EQ(got[1], SegmentStatistics{}) << "a segment without points";
  EXPECT_EQ(got[2].points, 1U);
  EXPECT_TRUE(describe_segments(cloud, labels, 0)->empty());
}

TEST(SegmentStatistics, OfLabelsThatDoNotFitAreAnError) {
  Cloud cloud = test::random_cloud(10, 1, 2, View::world());
  std::vector<std::uint32_t> labels(10, 1);
  labels[4] = 2;
  EXPECT_THAT(describe_segments(cloud, std::span(labels).first(9), 1).status().message(),
              testing::HasSubstr("9 labels of 1 segments for 10 points"));
  EXPECT_EQ(describe_segments(cloud, labels, 11).status().code(), absl::StatusCode::kInvalidArgument);
  cloud.y[4] = kNan;
  EXPECT_TRUE(describe_segments(cloud, labels, 1).ok()) << "nobody asks for segment 2";
  const absl::Status status = describe_segments(cloud, labels, 2).status();
  EXPECT_EQ(status.code(), absl::StatusCode::kInvalidArgument);
  EXPECT_THAT(status.message(), testing::HasSubstr("point 4 is not finite, but has label 2"));
}

TEST(SetNormals, TakesTheDirectionOfTheSum) {
  std::vector<SegmentStatistics> segments(3);
  const std::vector<Vector3d> normals{{0, 0, 3}, {0, 4, 0}, {1, 0, 0}, {-1, 0, 0}, {0, 0, 0}, {9, 9, 9}};
  const std::vector<std::uint32_t> segment_of_leaf{1, 1, 2, 2, 3, 4};
  ASSERT_TRUE(set_normals(normals, segment_of_leaf, segments).ok());
  ASSERT_TRUE(segments[0].normal);
  expect_near(*segments[0].normal, {0, 0.8, 0.6}, 1e-15);
  EXPECT_FALSE(segments[1].normal) << "they cancel out";
  EXPECT_FALSE(segments[2].normal);
}

/// A tabletop in the camera view, segmented.
class Described : public testing::Test {
 protected:
  static const Cloud& cloud() {
    static const Cloud cloud = synth::make_tabletop({.seed = 5})->cloud;
    return cloud;
  }
  static const Segmentation& segmentation() {
    static const Segmentation result = [] {
      Segmentation made = segment(cloud(), {}).value();
      EXPECT_TRUE(describe(cloud(), 1, {}, made).ok());
      return made;
    }();
    return result;
  }
};

TEST_F(Described, EveryPointIsInTheBoxOfItsSegment) {
  const Segmentation& s = segmentation();
  ASSERT_EQ(s.statistics.size(), s.segments);
  for (std::size_t i = 0; i < cloud().size(); ++i) {
    if (s.labels[i] == 0) continue;
    ASSERT_LE(beyond(s.statistics[s.labels[i] - 1].box, point(cloud(), i)), 1e-6) << "point " << i;
  }
}

TEST_F(Described, TheSegmentsAreThoseOfTheResult) {
  const Segmentation& s = segmentation();
  std::size_t points = 0;
  for (std::size_t k = 0; k < s.segments; ++k) {
    const SegmentStatistics& segment = s.statistics[k];
    EXPECT_GT(segment.points, 0U);
    EXPECT_LE(segment.points, s.statistics[k == 0 ? 0 : k - 1].points);
    points += segment.points;
    expect_valid(segment.box);
    EXPECT_LE(beyond(segment.box, segment.centroid), 1e-9);
    EXPECT_NEAR(segment.normal.value_or(Vector3d::UnitX()).norm(), 1, 1e-14);
  }
  EXPECT_EQ(points, s.segmented_points);
}

TEST_F(Described, TheLargestSegmentFacesTheCamera) {
  const SegmentStatistics& table = segmentation().statistics.at(0);
  ASSERT_TRUE(table.normal);
  EXPECT_LT(table.normal->dot(table.centroid), 0);
  EXPECT_GT(std::fabs(table.normal->dot(table.box.axes.col(2))), 0.99) << "a plane: its normal is the thinnest axis";
}

TEST_F(Described, NeitherTheOrderOfThePointsNorThreadsMatter) {
  const Segmentation& s = segmentation();
  std::vector<std::uint32_t> order(cloud().size());
  std::iota(order.begin(), order.end(), 0U);
  std::shuffle(order.begin(), order.end(), std::mt19937(1));
  const Cloud shuffled = test::permuted(cloud(), order);
  std::vector<std::uint32_t> labels;
  for (const std::uint32_t i : order) labels.push_back(s.labels[i]);
  const auto expected = describe_segments(cloud(), s.labels, s.segments).value();
  EXPECT_EQ(describe_segments(shuffled, labels, s.segments).value(), expected);
  for (const unsigned threads : {2U, 3U, 7U}) {
    EXPECT_EQ(describe_segments(cloud(), s.labels, s.segments, threads).value(), expected) << threads;
  }
}

TEST_F(Described, TheBytesAreTheSameOnEveryCpu) {
  std::uint64_t hash = 0xcbf29ce484222325ULL;  // FNV-1a over little-endian bytes
  const auto add = [&hash](double value) {
    for (int i = 0; i < 8; ++i) {
      hash = (hash ^ (std::bit_cast<std::uint64_t>(value) >> (8 * i) & 0xffU)) * 0x100000001b3ULL;
    }
  };
  const auto add_vec = [&add](const Vector3d& v) { add(v.x()), add(v.y()), add(v.z()); };
  for (const SegmentStatistics& s : segmentation().statistics) {
    add(s.points);
    add_vec(s.centroid), add_vec(s.box.center);
    for (int k = 0; k < 3; ++k) add_vec(s.box.axes.col(k));
    add_vec(s.box.half_extents), add_vec(s.color.value_or(Vector3d::Zero())),
        add_vec(s.normal.value_or(Vector3d::Zero()));
  }
  EXPECT_EQ(hash, 0x1d432a2f98900c1cULL);
}

TEST(DescribeSegments, IsCompleteOrStopped) {
  const std::uint32_t segments = kMostDescribedSegments;
  const Cloud cloud = test::random_cloud(segments, 10, 0, View::world());
  std::vector<std::uint32_t> labels(segments);
  std::iota(labels.begin(), labels.end(), 1U);
  const auto expected = describe_segments(cloud, labels, segments).value();
  bool stopped = true;
  for (std::uint64_t n = 1; stopped; ++n) {
    std::atomic<bool> cancelled = false;
    std::uint64_t looks = 0;
    WorkMeter meter([&](std::uint64_t) { cancelled = cancelled || ++looks == n; });
    const auto got = describe_segments(cloud, labels, segments, 1, StopToken(&cancelled, std::nullopt, &meter));
    stopped = cancelled;
    if (got.ok()) {
      EXPECT_EQ(*got, expected) << "look " << n;
    } else {
      EXPECT_EQ(got.status().code(), absl::StatusCode::kCancelled) << "look " << n;
    }
  }
}

TEST(Describe, LooksAtTheLargestSegmentsOnly) {
  const Cloud scattered = test::random_cloud(30'000, 400, 0, View::world(0, 0, 0));
  Segmentation s = segment(scattered, {.threshold = 0.0}).value();
  ASSERT_GT(s.segments, kMostDescribedSegments);
  ASSERT_TRUE(describe(scattered, 1, {}, s).ok());
  EXPECT_EQ(s.statistics.size(), kMostDescribedSegments);
}

TEST(Describe, OfNothingIsNothing) {
  Cloud cloud = test::unorganized();
  add(cloud, {kNan, 0, 0});
  Segmentation s = segment(cloud, {}).value();
  EXPECT_TRUE(describe(cloud, 1, {}, s).ok());
  EXPECT_TRUE(s.statistics.empty());
}

TEST(Describe, StopsSoon) {
  const Cloud cloud = test::random_cloud(200'000, 10, 0, View::world(0, 0, 0));
  const Segmentation segmented = segment(cloud, {.voxel_resolution = 0.1, .seed_resolution = 0.5}).value();
  for (const unsigned threads : {1U, 2U}) {
    std::uint64_t looks = 0;
    for (std::uint64_t n = 0; n == 0 || n < looks; n += 1 + looks / 40) {
      std::atomic<bool> cancelled = false;
      std::atomic<std::uint64_t> seen = 0, at_stop = 0;
      WorkMeter meter([&](std::uint64_t) {
        if (++seen != n) return;
        cancelled = true;
        at_stop = meter.units();  // what other threads did before the flag was set does not count
      });
      Segmentation s = segmented;
      const absl::Status status = describe(cloud, threads, StopToken(&cancelled, std::nullopt, &meter), s);
      if (n == 0) {
        ASSERT_TRUE(status.ok());
        looks = seen;
        EXPECT_GE(meter.units(), 3 * cloud.size());
        continue;
      }
      EXPECT_EQ(status.code(), absl::StatusCode::kCancelled) << "look " << n << " of " << looks;
      EXPECT_LE(meter.units() - at_stop, StopToken::kMostWorkAfterStop);
    }
  }
}

}  // namespace
}  // namespace segserve
