// SPDX-License-Identifier: Apache-2.0
// Furniture that stands at a wall stays apart from it.
#include <gtest/gtest.h>

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <map>
#include <vector>

#include "core/lab/synth/scene.hpp"
#include "segserve/segment.hpp"

namespace segserve {
namespace {

/// The part of the segments of floor and walls (labels 1 to 5) that are points of furniture.
double furniture_in_walls(const synth::SyntheticScene& scene, const Segmentation& result) {
  constexpr std::uint32_t kLastWall = 5;
  std::map<std::uint32_t, std::map<std::uint32_t, std::size_t>> points;  // by wall and segment
  std::vector<std::size_t> furniture(result.segments + std::size_t{1}), all(furniture.size());
  for (std::size_t i = 0; i < scene.label.size(); ++i) {
    const std::uint32_t segment = result.labels[i];
    ++all[segment];
    if (scene.label[i] <= kLastWall) {
      ++points[scene.label[i]][segment];
    } else {
      ++furniture[segment];
    }
  }
  double of_furniture = 0, of_all = 0;
  for (const auto& [wall, of_segment] : points) {
    const auto most = std::ranges::max_element(of_segment, {}, [](const auto& count) { return count.second; })->first;
    of_furniture += static_cast<double>(furniture[most]);
    of_all += static_cast<double>(all[most]);
  }
  return of_furniture / of_all;
}

TEST(Walls, ShelvesDoNotBecomePartOfThem) {
  // The shelves' backs stand two centimeters before a wall, in voxels of one and a half, and touch it in a few voxels.
  for (const std::uint32_t seed : {202U, 205U}) {
    const auto scene = synth::make_fused_room({.seed = seed, .points = 300'000});
    ASSERT_TRUE(scene.ok()) << scene.status();
    const auto result = segment(scene->cloud, {});
    ASSERT_TRUE(result.ok()) << result.status();
    EXPECT_LT(furniture_in_walls(*scene, *result), 0.03) << "seed " << seed;
  }
}

}  // namespace
}  // namespace segserve
