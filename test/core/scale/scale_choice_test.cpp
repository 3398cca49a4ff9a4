// SPDX-License-Identifier: Apache-2.0
#include "core/scale/scale_choice.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <limits>
#include <numeric>
#include <random>
#include <vector>

#include "core/base/stop_check.hpp"
#include "core/math/random.hpp"
#include "core/scale/camera_sampling.hpp"
#include "core/scale/cloud_sampling.hpp"
#include "segserve/segment.hpp"
#include "test/core/support/clouds.hpp"
#include "test/core/support/test_frame.hpp"

namespace segserve {
namespace {

/// The frame of a camera with this many columns that looks at the plane z = 1.5 m + slope x, with noise in 1/z.
Cloud camera_frame(int width, double slope = 0, double noise = 0) {
  Cloud cloud = test::unorganized(View::camera());
  Random random(7);
  const double pitch = 1.2 / width;
  for (int row = 0; row < 3 * width / 4; ++row) {
    for (int column = 0; column < width; ++column) {
      const double u = pitch * (column - 0.5 * width), v = pitch * (row - 0.375 * width);
      const double inverse = (1 - slope * u) / 1.5 + noise * random.gaussian();
      const auto z = static_cast<float>(1 / inverse);
      test::add(cloud, static_cast<float>(u) * z, static_cast<float>(v) * z, z, 0);
    }
  }
  return cloud;
}

/// A jittered sheet of n x n points, `step` meters apart, with noise across it, meters.
Cloud sheet(int n, double step, double noise = 0) {
  Cloud cloud = test::unorganized(View::world());
  Random random(5);
  for (int i = 0; i < n; ++i) {
    for (int k = 0; k < n; ++k) {
      const double x = step * (i + 0.3 * random.uniform()), y = step * (k + 0.3 * random.uniform());
      test::add(cloud, static_cast<float>(x), static_cast<float>(y),
                static_cast<float>(0.2 * x + noise * random.gaussian()), 0);
    }
  }
  return cloud;
}

CameraSampling camera_sampling(const Cloud& cloud, double edge = 0.006, const Options& options = {}) {
  const test::TestFrame frame(cloud, options);
  const StopToken stop;
  StopCheck check(stop);
  return estimate_camera_sampling(frame, edge, check);
}

CloudSampling cloud_sampling(const Cloud& cloud, double edge = 0.0075) {
  const test::TestFrame frame(cloud);
  const StopToken stop;
  StopCheck check(stop);
  return estimate_cloud_sampling(frame, edge, check);
}

ChosenScale chosen(const Cloud& cloud, const Options& options = {}) {
  const test::TestFrame frame(cloud, options);
  return *choose_scale(frame);
}

Cloud shuffled(const Cloud& cloud) {
  std::vector<std::uint32_t> order(cloud.size());
  std::iota(order.begin(), order.end(), 0U);
  std::ranges::shuffle(order, std::mt19937(3));
  return test::permuted(cloud, order);
}

TEST(CameraSampling, TellsThePitchAndTheNoise) {
  for (const int width : {320, 640}) {
    const CameraSampling clean = camera_sampling(camera_frame(width));
    EXPECT_NEAR(clean.pitch, 1.2 / width, 0.05 * 1.2 / width);
    EXPECT_LT(clean.noise, 1e-5);
    EXPECT_LT(clean.slope, 1e-5) << "the plane faces the camera";
  }
  // The mean over the 10 points of a column leaves a third of the noise.
  const double noise = camera_sampling(camera_frame(640, 0, 0.003)).noise;
  const double points_of_column = std::pow(0.006 / (1.2 / 640), 2);
  EXPECT_NEAR(noise, 0.003 / std::sqrt(points_of_column), 0.2 * noise);
}

TEST(CameraSampling, TellsTheStepsOfASlantedPlane) {
  const double slope = 1.2, pitch = 1.2 / 640;
  EXPECT_NEAR(camera_sampling(camera_frame(640, slope)).slope, slope * pitch / 1.5, 0.1 * slope * pitch / 1.5);
}

TEST(CameraSampling, DoesNotDependOnTheOrderOfThePoints) {
  const Cloud cloud = camera_frame(320, 0.5, 0.002);
  const CameraSampling a = camera_sampling(cloud), b = camera_sampling(shuffled(cloud));
  EXPECT_EQ(a.pitch, b.pitch);
  EXPECT_EQ(a.noise, b.noise);
  EXPECT_EQ(a.slope, b.slope);
}

TEST(CameraSampling, LooksOnlyAtPointsThatAreSelected) {
  Cloud cloud = camera_frame(320);
  const CameraSampling alone = camera_sampling(cloud);
  for (int i = 0; i < 20000; ++i) test::add(cloud, 0.01F * static_cast<float>(i % 100), 0, 9, 0);
  EXPECT_EQ(camera_sampling(cloud, 0.006, {.crop_max_z = 5}).pitch, alone.pitch);
}

TEST(CloudSampling, TellsTheSpacingTheNoiseAndTheExtent) {
  for (const double step : {0.01, 0.05, 0.2}) {
    const CloudSampling sampling = cloud_sampling(sheet(150, step, 0.02 * step));
    EXPECT_GT(sampling.connected_edge, 0.9 * step);
    EXPECT_LT(sampling.connected_edge, 2 * step);
    EXPECT_NEAR(sampling.noise, 0.02 * step, 0.004 * step);
    EXPECT_NEAR(sampling.extent, 0.9 * 150 * step * std::sqrt(2.04), 0.05 * 150 * step);
  }
}

TEST(CloudSampling, DoesNotDependOnTheOrderOfThePoints) {
  const Cloud cloud = sheet(300, 0.03, 0.001);
  const CloudSampling a = cloud_sampling(cloud), b = cloud_sampling(shuffled(cloud));
  EXPECT_EQ(a.connected_edge, b.connected_edge);
  EXPECT_EQ(a.noise, b.noise);
  EXPECT_EQ(a.extent, b.extent);
}

TEST(CloudSampling, SurvivesOddClouds) {
  Cloud few = test::unorganized(View::world());
  test::add_patch(few, 0, 0, 0, 0.05F, 0.01F, 0);
  EXPECT_EQ(cloud_sampling(few).connected_edge, 0) << "too few points to tell";
  Cloud one_place = test::unorganized(View::world());
  for (int i = 0; i < 300000; ++i) test::add(one_place, 1, 1, 1, 0);
  EXPECT_EQ(cloud_sampling(one_place).connected_edge, 0) << "no extent";
  for (int i = 0; i < 400; ++i) test::add(one_place, static_cast<float>(i), 2, 3, 0);
  EXPECT_GE(cloud_sampling(one_place).extent, 0);
  Cloud far = test::unorganized(View::world());
  Random random(1);
  for (int i = 0; i < 5000; ++i) {
    test::add(far, static_cast<float>(1e30 * random.uniform()), static_cast<float>(1e30 * random.uniform()), 0, 0);
  }
  EXPECT_TRUE(std::isfinite(cloud_sampling(far).connected_edge));
}

TEST(ScaleChoice, KeepsTheUsualVoxelsWhereTheyFit) {
  const ChosenScale camera = chosen(camera_frame(640));
  EXPECT_EQ(camera.scale.voxel, 0.007);
  EXPECT_EQ(camera.scale.seed, 0.028);
  EXPECT_TRUE(camera.scale.in_proportion);
  EXPECT_EQ(camera.reason, ResolutionReason::kDense);
  const ChosenScale world = chosen(sheet(400, 0.004));
  EXPECT_EQ(world.scale.voxel, 0.0075);
  EXPECT_EQ(world.reason, ResolutionReason::kDense);
}

TEST(ScaleChoice, FollowsTheDataWhereTheyDoNot) {
  const ChosenScale few_pixels = chosen(camera_frame(160));
  EXPECT_NEAR(few_pixels.scale.voxel, 1.6 * 1.2 / 160, 0.001);
  EXPECT_EQ(few_pixels.reason, ResolutionReason::kSpacing);
  const ChosenScale sparse = chosen(sheet(150, 0.05));
  EXPECT_GT(sparse.scale.voxel, 0.045);
  EXPECT_EQ(sparse.scale.seed, 4 * sparse.scale.voxel);
  EXPECT_EQ(sparse.reason, ResolutionReason::kSpacing);
  const ChosenScale noisy = chosen(sheet(700, 0.003, 0.003));
  EXPECT_NEAR(noisy.scale.voxel, 8 * 0.003, 0.008);
  EXPECT_EQ(noisy.reason, ResolutionReason::kNoise);
  const ChosenScale tiny = chosen(sheet(300, 0.0005));
  EXPECT_LT(tiny.scale.voxel, 0.003);
  EXPECT_EQ(tiny.reason, ResolutionReason::kExtent);
}

TEST(ScaleChoice, IsNotDeceivedByPointsAtTheSamePlace) {
  const Cloud once = sheet(120, 0.05);
  Cloud stacked = once;
  for (int copy = 0; copy < 5; ++copy) {
    for (std::size_t i = 0; i < once.size(); ++i) test::add(stacked, once.x[i], once.y[i], once.z[i], 0);
  }
  EXPECT_GT(chosen(stacked).scale.voxel, 0.04);
}

TEST(ScaleChoice, DoesNotCutRegularGridsIntoTiles) {
  for (const float pitch : {0.05F, 0.0505F, 0.1F, 0.25F}) {
    Cloud grid = test::unorganized(View::world());
    for (int i = 0; i < 120; ++i) {
      for (int k = 0; k < 120; ++k) test::add(grid, pitch * static_cast<float>(i), pitch * static_cast<float>(k), 0, 0);
    }
    EXPECT_EQ(segment(grid, {})->segments, 1U) << pitch;
  }
}

TEST(ScaleChoice, SaysSoWhereTheLargestVoxelsAreTooSmall) {
  EXPECT_GT(segment(sheet(100, 7), {})->fitting_resolution.value_or(0), 1);
  EXPECT_EQ(segment(sheet(100, 0.05), {})->fitting_resolution, std::nullopt);
}

TEST(ScaleChoice, ACloudSmallerThanAVoxelGetsTheFinestOnes) {
  for (const int n : {10, 30, 100}) {
    const ChosenScale speck = chosen(sheet(n, 1e-5));
    EXPECT_EQ(speck.scale.voxel, 0.001);
    EXPECT_EQ(speck.reason, ResolutionReason::kExtent);
    EXPECT_EQ(speck.fitting_voxel, 0) << "no larger ones would be better";
  }
}

TEST(ScaleChoice, NumbersFixIt) {
  const Cloud cloud = sheet(150, 0.05);
  const ChosenScale both = chosen(cloud, {.voxel_resolution = 0.01, .seed_resolution = 0.03});
  EXPECT_EQ(both.scale.voxel, 0.01);
  EXPECT_EQ(both.scale.seed, 0.03);
  EXPECT_EQ(both.reason, ResolutionReason::kGiven);
  EXPECT_EQ(chosen(cloud, {.voxel_resolution = 0.01}).scale.seed, 0.04);
  EXPECT_LE(chosen(cloud, {.seed_resolution = 0.02}).scale.voxel, 0.02) << "voxels are not larger than seeds are apart";
  const ChosenScale paper = chosen(cloud, {.method = Method::kLambda});
  EXPECT_EQ(paper.scale.voxel, 0.008);
  EXPECT_EQ(paper.scale.seed, 0.08);
  EXPECT_FALSE(chosen(camera_frame(160), {.method = Method::kLambda}).scale.in_proportion);
}

TEST(ScaleChoice, NoiseCountsFromTheDepthAtWhichItExceedsAVoxel) {
  const VoxelScale clean = chosen(camera_frame(640)).scale, noisy = chosen(camera_frame(640, 0, 0.01)).scale;
  EXPECT_GT(clean.noise_depth, 100);
  EXPECT_LT(noisy.noise_depth, 1.5);
  EXPECT_LT(noisy.elongation_depth, noisy.noise_depth);
  EXPECT_EQ(noisy.excess_noise(0.5 * noisy.noise_depth), 0);
  EXPECT_DOUBLE_EQ(noisy.excess_noise(1.5 * noisy.noise_depth), 0.5);
  EXPECT_EQ(noisy.excess_noise(100 * noisy.noise_depth), 1);
  EXPECT_DOUBLE_EQ(noisy.elongation(3 * noisy.elongation_depth), 3);
}

TEST(ScaleChoice, StopsWhenAsked) {
  const Cloud flat = sheet(150, 0.05), frame = camera_frame(160);
  const std::atomic<bool> cancelled = true;
  for (const Cloud* cloud : {&flat, &frame}) {
    const test::TestFrame stopped(*cloud, {}, StopToken(&cancelled));
    EXPECT_EQ(choose_scale(stopped).status().code(), absl::StatusCode::kCancelled);
  }
}

TEST(ScaleChoice, ASceneAndItsCopyFarAwayAreSegmentedAlike) {
  // A box on a table, and the same at four times the distance.
  Cloud near = camera_frame(320, 0.4);
  for (std::size_t i = 0; i < near.size(); ++i) {
    if (std::fabs(near.x[i]) > 0.15F || std::fabs(near.y[i]) > 0.15F) continue;
    near.x[i] *= 0.8F, near.y[i] *= 0.8F, near.z[i] *= 0.8F;
  }
  Cloud far = near;
  for (std::vector<float>* axis : {&far.x, &far.y, &far.z}) {
    for (float& value : *axis) value *= 4;
  }
  const Segmentation a = *segment(near, {}), b = *segment(far, {});
  EXPECT_EQ(a.segments, 2U);
  EXPECT_EQ(b.segments, 2U);
  EXPECT_EQ(a.labels, b.labels);
  EXPECT_NEAR(static_cast<double>(a.voxels) / static_cast<double>(b.voxels), 1, 0.05);
}

TEST(ResolutionReason, HasANameInBothDirections) {
  for (const auto reason : {ResolutionReason::kGiven, ResolutionReason::kDense, ResolutionReason::kSpacing,
                            ResolutionReason::kNoise, ResolutionReason::kExtent}) {
    EXPECT_EQ(resolution_reason(name(reason)), reason);
  }
  EXPECT_EQ(resolution_reason("magic"), std::nullopt);
}

}  // namespace
}  // namespace segserve
