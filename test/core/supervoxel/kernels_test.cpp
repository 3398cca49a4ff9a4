// The code for AVX2 gives the bytes of the code for any CPU, and both what the formula says. On a machine without AVX2
// both are the same code.
#include "segserve/supervoxel/kernels/kernels.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <bit>
#include <random>
#include <set>
#include <vector>

#include "segserve/math/cpu.hpp"
#include "segserve/supervoxel/state.hpp"

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
      voxels.push_back(random_feature(colored));
      voxels.back().distance = v % 9 == 0 ? kUnreached : 1 + number();
      owner.push_back(static_cast<std::uint32_t>(random() % 6));
      // Some have more neighbours than fit any buffer.
      const std::size_t count = v % 50 == 0 ? 700 : random() % 40;
      std::set<std::uint32_t> some;
      while (some.size() < count) some.insert(static_cast<std::uint32_t>(random() % kVoxels));
      some.erase(v);
      neighbor.insert(neighbor.end(), some.begin(), some.end());
      offset.push_back(static_cast<std::uint32_t>(neighbor.size()));
    }
    seen.assign(kVoxels, 0);
  }
  float number() { return static_cast<float>(random() % 20001) / 10000.0F - 1.0F; }
  Feature random_feature(bool colored) {
    const float c = colored ? 1 : 0;
    return {number(), number(), number(),     number(),     number(),     number(),
            0,        0,        c * number(), c * number(), c * number(), 0};
  }
  Turn turn() {
    return {voxels.data(), owner.data(), seen.data(), offset.data(), neighbor.data(), neighbor.size(), 3, 77};
  }
  static constexpr std::uint32_t kVoxels = 900;
  std::mt19937 random{11};
  std::vector<Feature> voxels;
  std::vector<std::uint32_t> owner, seen, neighbor, offset{0};
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
      const Feature centre = count == 5 ? scene.voxels[7] : scene.random_feature(colored);
      std::vector<std::uint32_t> candidates = first_voxels(count), kept;
      std::vector<Claim> expected;
      for (const std::uint32_t v : candidates) {
        const float d = distance_between(distance, centre, scene.voxels[v]);
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
        EXPECT_EQ(scene.seen[claims[i].voxel], 77U);
      }
      candidates.resize(count - found);
      EXPECT_EQ(candidates, kept);
      EXPECT_EQ(static_cast<std::size_t>(std::ranges::count(scene.seen, 77U)), count);
    }
  }
}

TEST_P(GrowthKernels, KeepTheClaimsThatTouchTheCluster) {
  Scene scene(false);
  std::vector<Claim> claims;
  std::vector<std::uint32_t> expected, kept;
  for (const std::uint32_t v : first_voxels(400)) {
    scene.owner[v] = 1;
    claims.push_back({v, 0});
    scene.seen[v] = 77;
  }
  for (const Claim& claim : claims) {
    const auto begin = scene.neighbor.begin() + scene.offset[claim.voxel];
    const auto end = scene.neighbor.begin() + scene.offset[claim.voxel + 1];
    if (std::any_of(begin, end, [&](std::uint32_t u) { return scene.owner[u] == 3; })) expected.push_back(claim.voxel);
  }
  const std::size_t count =
      kernels_of(GetParam()).keep_touching(scene.turn(), claims.data(), claims.size(), claims.data());
  for (std::size_t i = 0; i < count; ++i) kept.push_back(claims[i].voxel);
  EXPECT_EQ(kept, expected);
  EXPECT_LT(expected.size(), 400U);
  for (const std::uint32_t v : first_voxels(400)) {
    EXPECT_EQ(scene.seen[v], std::ranges::count(expected, v) > 0 ? 77U : 0U) << v;
  }
}

TEST_P(GrowthKernels, FindEachFreshNeighbourOnce) {
  for (const std::size_t count : {std::size_t{0}, std::size_t{1}, std::size_t{30}, std::size_t{300}}) {
    Scene scene(false);
    std::vector<Claim> claims;
    std::vector<std::uint32_t> expected;
    for (const std::uint32_t v : first_voxels(count)) {
      scene.owner[v] = 3;
      claims.push_back({v, 0});
    }
    for (std::uint32_t v = 5; v < Scene::kVoxels; v += 11) scene.seen[v] = 77;
    std::vector<std::uint32_t> seen = scene.seen;
    std::size_t neighbors = 0;
    for (const Claim& claim : claims) {
      for (std::uint32_t at = scene.offset[claim.voxel]; at < scene.offset[claim.voxel + 1]; ++at, ++neighbors) {
        const std::uint32_t u = scene.neighbor[at];
        if (scene.owner[u] != 3 && std::exchange(seen[u], 77) != 77) expected.push_back(u);
      }
    }
    std::vector<std::uint32_t> fresh(neighbors + 1);
    fresh.resize(kernels_of(GetParam()).find_fresh(scene.turn(), claims.data(), count, fresh.data()));
    EXPECT_EQ(fresh, expected);
  }
}

INSTANTIATE_TEST_SUITE_P(OfAll, GrowthKernels, testing::Values(Cpu::kAny, best_cpu()),
                         [](const auto& param) { return param.index == 0 ? "Plain" : "Best"; });

}  // namespace
}  // namespace segserve::growth
