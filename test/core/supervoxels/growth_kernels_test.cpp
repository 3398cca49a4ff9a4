// The code for AVX2 gives the bytes of the code for any CPU, and both what the formula says. On a machine without AVX2
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

const Kernels& kernels_of(Cpu cpu) {
  use_cpu(cpu);
  const Kernels& chosen = kernels();
  use_cpu(best_cpu());
  return chosen;
}

/// Voxels anywhere, with owners and neighbours of all kinds.
struct Scene {
  explicit Scene(bool colored) {
    for (std::uint32_t v = 0; v < kVoxels; ++v) {
      Voxel voxel{};
      voxel.feature = random_feature(colored);
      voxel.distance = v % 9 == 0 ? kUnreached : 1 + number();
      voxel.owner = static_cast<std::uint32_t>(random() % 6);
      // Some have more neighbours than fit any buffer.
      const std::size_t count = v % 50 == 0 ? 700 : random() % 40;
      std::set<std::uint32_t> some;
      while (some.size() < count) some.insert(static_cast<std::uint32_t>(random() % kVoxels));
      some.erase(v);
      voxel.first = static_cast<std::uint32_t>(neighbor.size());
      voxel.neighbors = static_cast<std::uint32_t>(some.size());
      neighbor.insert(neighbor.end(), some.begin(), some.end());
      voxels.push_back(voxel);
    }
  }
  float number() { return static_cast<float>(random() % 20001) / 10000.0F - 1.0F; }
  Feature random_feature(bool colored) {
    const float c = colored ? 1 : 0;
    return {number(), number(), number(), number(), number(), number(), c * number(), c * number(), c * number()};
  }
  std::span<const std::uint32_t> neighbors_of(std::uint32_t v) const {
    return std::span(neighbor).subspan(voxels[v].first, voxels[v].neighbors);
  }
  Turn turn() { return {voxels.data(), neighbor.data(), neighbor.size(), 3, 77}; }
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

class GrowthKernels : public testing::TestWithParam<Cpu> {};

TEST_P(GrowthKernels, ClaimWhatIsNearerThanItsOwner) {
  for (const bool colored : {false, true}) {
    for (std::size_t count = 0; count <= 35; ++count) {
      Scene scene(colored);
      const Distance distance{1.25F, colored};
      const Feature centre = count == 5 ? scene.voxels[7].feature : scene.random_feature(colored);
      std::vector<std::uint32_t> candidates = first_voxels(count), kept;
      std::vector<Claim> expected;
      for (const std::uint32_t v : candidates) {
        const float d = distance_between(distance, centre, scene.voxels[v].feature);
        if (d < scene.voxels[v].distance) {
          expected.push_back({v, d});
        } else {
          kept.push_back(v);
        }
      }
      std::vector<Claim> claims(count + 1);
      const std::size_t found =
          kernels_of(GetParam())
              .find_claims(scene.turn(), distance, centre, candidates.data(), count, claims.data(), candidates.data());
      ASSERT_EQ(found, expected.size());
      for (std::size_t i = 0; i < found; ++i) {
        EXPECT_EQ(claims[i].voxel, expected[i].voxel);
        EXPECT_EQ(std::bit_cast<std::uint32_t>(claims[i].distance), std::bit_cast<std::uint32_t>(expected[i].distance));
        EXPECT_EQ(scene.voxels[claims[i].voxel].seen, 77U);
      }
      candidates.resize(count - found);
      EXPECT_EQ(candidates, kept);
      EXPECT_EQ(static_cast<std::size_t>(std::ranges::count(scene.voxels, 77U, &Voxel::seen)), count);
    }
  }
}

TEST_P(GrowthKernels, KeepTheClaimsThatTouchTheCluster) {
  Scene scene(false);
  std::vector<Claim> claims;
  std::vector<std::uint32_t> expected, kept;
  std::size_t neighbors = 0;
  for (const std::uint32_t v : first_voxels(400)) {
    scene.voxels[v].owner = 1;
    claims.push_back({v, 0});
    scene.voxels[v].seen = 77;
    neighbors += scene.voxels[v].neighbors;
  }
  for (const Claim& claim : claims) {
    const auto touches = [&](std::uint32_t u) { return scene.voxels[u].owner == 3; };
    if (std::ranges::any_of(scene.neighbors_of(claim.voxel), touches)) expected.push_back(claim.voxel);
  }
  const Found found = kernels_of(GetParam()).keep_touching(scene.turn(), claims.data(), claims.size(), claims.data());
  for (std::size_t i = 0; i < found.count; ++i) kept.push_back(claims[i].voxel);
  EXPECT_EQ(kept, expected);
  EXPECT_EQ(found.visits, neighbors);
  EXPECT_LT(expected.size(), 400U);
  for (const std::uint32_t v : first_voxels(400)) {
    EXPECT_EQ(scene.voxels[v].seen, std::ranges::count(expected, v) > 0 ? 77U : 0U) << v;
  }
}

TEST_P(GrowthKernels, FindEachFreshNeighbourOnce) {
  for (const std::size_t count : {std::size_t{0}, std::size_t{1}, std::size_t{30}, std::size_t{300}}) {
    Scene scene(false);
    std::vector<Claim> claims;
    std::vector<std::uint32_t> expected;
    for (const std::uint32_t v : first_voxels(count)) {
      scene.voxels[v].owner = 3;
      claims.push_back({v, 0});
    }
    for (std::uint32_t v = 5; v < Scene::kVoxels; v += 11) scene.voxels[v].seen = 77;
    std::vector<bool> seen;
    for (const Voxel& voxel : scene.voxels) seen.push_back(voxel.seen == 77);
    std::size_t neighbors = 0;
    for (const Claim& claim : claims) {
      for (const std::uint32_t u : scene.neighbors_of(claim.voxel)) {
        ++neighbors;
        if (scene.voxels[u].owner != 3 && !seen[u]) expected.push_back(u);
        seen[u] = true;
      }
    }
    std::vector<std::uint32_t> fresh(neighbors + 1);
    const Found found = kernels_of(GetParam()).find_fresh(scene.turn(), claims.data(), count, fresh.data());
    fresh.resize(found.count);
    EXPECT_EQ(found.visits, neighbors);
    EXPECT_EQ(fresh, expected);
  }
}

INSTANTIATE_TEST_SUITE_P(OfAll, GrowthKernels, testing::Values(Cpu::kAny, best_cpu()),
                         [](const auto& param) { return param.index == 0 ? "Plain" : "Best"; });

}  // namespace
}  // namespace segserve::growth
