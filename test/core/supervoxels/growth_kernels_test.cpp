// SPDX-License-Identifier: Apache-2.0
//
// The kernels for AVX2 give the same bytes as the baseline, and both compute the formula. On a machine without AVX2
// both are the same code.
#include "core/supervoxels/simd/growth_kernels.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <bit>
#include <random>
#include <set>
#include <span>
#include <vector>

#include "core/simd/simd_dispatch.hpp"
#include "core/supervoxels/growth_state.hpp"

namespace segserve::growth {
namespace {

const GrowthKernels& kernels_of(SimdTarget target) {
  set_simd_target(target);
  const GrowthKernels& chosen = growth_kernels();
  set_simd_target(best_simd_target());
  return chosen;
}

/// Random voxels, with clusters and neighbors of all kinds.
struct Scene {
  explicit Scene(bool colored) {
    for (std::uint32_t v = 0; v < kVoxels; ++v) {
      Voxel voxel{};
      voxel.feature = random_feature(colored);
      voxel.distance = v % 9 == 0 ? kUnreached : 1 + number();
      voxel.cluster = static_cast<std::uint32_t>(random() % 6);
      // Some have more neighbors than any buffer has room for.
      const std::size_t count = v % 50 == 0 ? 700 : random() % 40;
      std::set<std::uint32_t> some;
      while (some.size() < count) some.insert(static_cast<std::uint32_t>(random() % kVoxels));
      some.erase(v);
      voxel.first_neighbor = static_cast<std::uint32_t>(neighbor.size());
      voxel.neighbor_count = static_cast<std::uint32_t>(some.size());
      neighbor.insert(neighbor.end(), some.begin(), some.end());
      voxels.push_back(voxel);
    }
  }
  float number() { return static_cast<float>(random() % 20001) / 10000.0F - 1.0F; }
  Feature random_feature(bool colored) {
    const float c = colored ? 1 : 0;
    Feature feature{};
    for (std::size_t i = 0; i < Feature::kSize; ++i) feature.value[i] = (i < Feature::kRed ? 1 : c) * number();
    return feature;
  }
  std::span<const std::uint32_t> neighbors_of(std::uint32_t v) const {
    return std::span(neighbor).subspan(voxels[v].first_neighbor, voxels[v].neighbor_count);
  }
  Expansion expansion() { return {voxels.data(), neighbor.data(), neighbor.size(), 3, 77}; }
  static constexpr std::uint32_t kVoxels = 900;
  std::mt19937 random{11};
  std::vector<Voxel> voxels;
  std::vector<std::uint32_t> neighbor;
};

std::vector<std::uint32_t> first_voxels(std::size_t count) {
  std::vector<std::uint32_t> voxels(count);
  for (std::uint32_t i = 0; i < count; ++i) voxels[i] = (i * 7) % Scene::kVoxels;
  return voxels;
}

class GrowthKernelsTest : public testing::TestWithParam<SimdTarget> {};

TEST_P(GrowthKernelsTest, AssignCandidatesThatAreNearerThanToTheirOwnCluster) {
  for (const bool colored : {false, true}) {
    for (std::size_t count = 0; count <= 35; ++count) {
      Scene scene(colored);
      const DistanceWeights weights{1.25F, colored};
      const Feature center = count == 5 ? scene.voxels[7].feature : scene.random_feature(colored);
      std::vector<std::uint32_t> candidates = first_voxels(count), kept;
      std::vector<AssignedVoxel> expected;
      for (const std::uint32_t v : candidates) {
        const float d = distance_between(weights, center, scene.voxels[v].feature);
        if (d < scene.voxels[v].distance) {
          expected.push_back({v, d});
        } else {
          kept.push_back(v);
        }
      }
      std::vector<AssignedVoxel> assigned(count + 1);
      const std::size_t found = kernels_of(GetParam())
                                    .assign_candidates(scene.expansion(), weights, center, candidates.data(), count,
                                                       assigned.data(), candidates.data());
      ASSERT_EQ(found, expected.size());
      for (std::size_t i = 0; i < found; ++i) {
        EXPECT_EQ(assigned[i].voxel, expected[i].voxel);
        EXPECT_EQ(std::bit_cast<std::uint32_t>(assigned[i].distance),
                  std::bit_cast<std::uint32_t>(expected[i].distance));
        EXPECT_EQ(scene.voxels[assigned[i].voxel].visited_in, 77U);
      }
      candidates.resize(count - found);
      EXPECT_EQ(candidates, kept);
      EXPECT_EQ(static_cast<std::size_t>(std::ranges::count(scene.voxels, 77U, &Voxel::visited_in)), count);
    }
  }
}

TEST_P(GrowthKernelsTest, KeepAssignedVoxelsThatAreAdjacentToTheCluster) {
  Scene scene(false);
  std::vector<AssignedVoxel> assigned;
  std::vector<std::uint32_t> expected, kept;
  std::size_t neighbors = 0;
  for (const std::uint32_t v : first_voxels(400)) {
    scene.voxels[v].cluster = 1;
    assigned.push_back({v, 0});
    scene.voxels[v].visited_in = 77;
    neighbors += scene.voxels[v].neighbor_count;
  }
  for (const AssignedVoxel& one : assigned) {
    const auto in_cluster = [&](std::uint32_t u) { return scene.voxels[u].cluster == 3; };
    if (std::ranges::any_of(scene.neighbors_of(one.voxel), in_cluster)) expected.push_back(one.voxel);
  }
  const QueryCounts counts =
      kernels_of(GetParam()).keep_adjacent(scene.expansion(), assigned.data(), assigned.size(), assigned.data());
  for (std::size_t i = 0; i < counts.found; ++i) kept.push_back(assigned[i].voxel);
  EXPECT_EQ(kept, expected);
  EXPECT_EQ(counts.visited, neighbors);
  EXPECT_LT(expected.size(), 400U);
  for (const std::uint32_t v : first_voxels(400)) {
    EXPECT_EQ(scene.voxels[v].visited_in, std::ranges::count(expected, v) > 0 ? 77U : 0U) << v;
  }
}

TEST_P(GrowthKernelsTest, FindEachNewCandidateOnce) {
  for (const std::size_t count : {std::size_t{0}, std::size_t{1}, std::size_t{30}, std::size_t{300}}) {
    Scene scene(false);
    std::vector<AssignedVoxel> assigned;
    std::vector<std::uint32_t> expected;
    for (const std::uint32_t v : first_voxels(count)) {
      scene.voxels[v].cluster = 3;
      assigned.push_back({v, 0});
    }
    for (std::uint32_t v = 5; v < Scene::kVoxels; v += 11) scene.voxels[v].visited_in = 77;
    std::vector<bool> visited;
    for (const Voxel& voxel : scene.voxels) visited.push_back(voxel.visited_in == 77);
    std::size_t neighbors = 0;
    for (const AssignedVoxel& one : assigned) {
      for (const std::uint32_t u : scene.neighbors_of(one.voxel)) {
        ++neighbors;
        if (scene.voxels[u].cluster != 3 && !visited[u]) expected.push_back(u);
        visited[u] = true;
      }
    }
    std::vector<std::uint32_t> new_candidates(neighbors + 1);
    const QueryCounts counts =
        kernels_of(GetParam()).find_new_candidates(scene.expansion(), assigned.data(), count, new_candidates.data());
    new_candidates.resize(counts.found);
    EXPECT_EQ(counts.visited, neighbors);
    EXPECT_EQ(new_candidates, expected);
  }
}

INSTANTIATE_TEST_SUITE_P(Targets, GrowthKernelsTest, testing::Values(SimdTarget::kBaseline, best_simd_target()),
                         [](const auto& param) { return param.index == 0 ? "Baseline" : "Best"; });

}  // namespace
}  // namespace segserve::growth
