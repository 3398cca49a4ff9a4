// SPDX-License-Identifier: Apache-2.0
#include "core/merging/noisy_planes.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstdint>
#include <functional>
#include <map>
#include <numeric>
#include <random>
#include <vector>

#include "core/math/random.hpp"
#include "segserve/segment.hpp"
#include "test/core/support/clouds.hpp"

namespace segserve {
namespace {

/// The frame of a noisy camera whose neighboring errors are alike. `inverse_depth` gives 1/z at (x/z, y/z).
Cloud noisy_frame(const std::function<double(double, double)>& inverse_depth, double noise, unsigned seed = 7) {
  constexpr int kWidth = 320, kHeight = 240, kBlob = 6;
  Cloud cloud = test::unorganized(View::camera());
  Random random(seed);
  std::vector<double> blob(static_cast<std::size_t>(kWidth / kBlob + 1) * (kHeight / kBlob + 1));
  for (double& b : blob) b = random.gaussian();
  for (int row = 0; row < kHeight; ++row) {
    for (int column = 0; column < kWidth; ++column) {
      const double u = (column - 160) / 270.0, v = (row - 120) / 270.0;
      const double error = blob[static_cast<std::size_t>(row / kBlob * (kWidth / kBlob + 1) + column / kBlob)];
      const auto z = static_cast<float>(1 / (inverse_depth(u, v) + noise * (error + 0.5 * random.gaussian())));
      test::add(cloud, static_cast<float>(u) * z, static_cast<float>(v) * z, z, 0x808080);
    }
  }
  return cloud;
}

/// The segment with most of the points where `is_there` holds, and its share of them.
std::pair<std::uint32_t, double> majority(const Cloud& cloud, const Segmentation& result,
                                          const std::function<bool(double, double)>& is_there) {
  std::map<std::uint32_t, double> counts;
  double all = 0;
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    const double z = cloud.z[i];
    if (is_there(cloud.x[i] / z, cloud.y[i] / z)) ++counts[result.labels[i]], ++all;
  }
  const auto most = std::ranges::max_element(counts, {}, [](const auto& c) { return c.second; });
  return {most->first, most->second / all};
}

bool is_left(double u, double) { return u < -0.05; }
bool is_right(double u, double) { return u > 0.05; }

TEST(NoisyPlanes, AFarWallIsOneSegment) {
  const Cloud wall = noisy_frame([](double u, double) { return 0.2 + 0.05 * u; }, 0.004);
  const Segmentation result = *segment(wall, {});
  ASSERT_TRUE(result.resolution.noise_depth);
  ASSERT_LT(*result.resolution.noise_depth, 3) << "the wall is 5 m away";
  EXPECT_GT(majority(wall, result, [](double, double) { return true; }).second, 0.97);
}

TEST(NoisyPlanes, TwoWallsThatMeetStayTwo) {
  const Cloud corner =
      noisy_frame([](double u, double) { return 0.2 + 0.12 * (u < 0 ? -u : u); }, 0.004);  // nearest at both sides
  const Segmentation result = *segment(corner, {});
  const auto left = majority(corner, result, is_left), right = majority(corner, result, is_right);
  EXPECT_GT(left.second, 0.9);
  EXPECT_GT(right.second, 0.9);
  EXPECT_NE(left.first, right.first);
}

TEST(NoisyPlanes, WhatStandsBeforeTheWallStaysApart) {
  const auto is_box = [](double u, double v) { return u > 0.1 && u < 0.4 && v > 0 && v < 0.3; };
  const Cloud cloud = noisy_frame([&](double u, double v) { return is_box(u, v) ? 0.25 : 0.2; }, 0.004);
  const Segmentation result = *segment(cloud, {});
  const auto box = majority(cloud, result, is_box), wall = majority(cloud, result, is_left);
  EXPECT_GT(box.second, 0.9);
  EXPECT_GT(wall.second, 0.9);
  EXPECT_NE(box.first, wall.first);
}

TEST(NoisyPlanes, DependNeitherOnTheOrderOfThePointsNorOnThreads) {
  const Cloud cloud =
      noisy_frame([](double u, double v) { return 0.2 + 0.1 * u + (v > 0.2 ? 0.3 * (v - 0.2) : 0); }, 0.004);
  std::vector<std::uint32_t> order(cloud.size());
  std::iota(order.begin(), order.end(), 0U);
  std::ranges::shuffle(order, std::mt19937(3));
  const Segmentation once = *segment(cloud, {}), shuffled = *segment(test::permuted(cloud, order), {});
  EXPECT_EQ(segment(cloud, {.threads = 3})->labels, once.labels);
  for (std::size_t i = 0; i < order.size(); ++i) ASSERT_EQ(shuffled.labels[i], once.labels[order[i]]);
}

TEST(NoisyPlanes, TheTreeStaysMonotone) {
  const Segmentation result = *segment(noisy_frame([](double u, double) { return 0.2 + 0.05 * u; }, 0.004), {});
  EXPECT_TRUE(check(result.tree).ok());
  for (std::size_t r = 0; r < result.tree.row_count(); ++r) {
    if (result.tree.kind[r] != MergeKind::kMerged) continue;
    EXPECT_EQ(result.tree.height[r], result.tree.weight[r]) << r;
  }
}

}  // namespace
}  // namespace segserve
