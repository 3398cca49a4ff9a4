#include "segserve/supervoxel/distances.hpp"

#include <gtest/gtest.h>

#include <bit>
#include <random>
#include <vector>

namespace segserve::growth {
namespace {

TEST(Distance, OfManyVoxelsIsThatOfEachToTheBit) {
  std::mt19937 random(11);
  const auto number = [&] { return static_cast<float>(random() % 20001) / 10000.0F - 1.0F; };
  const auto feature = [&] {
    return Feature{number(), number(), number(), number(), number(), number(), number(), number(), number()};
  };
  std::vector<Voxel> voxels(40);
  for (Voxel& voxel : voxels) voxel.feature = feature();
  voxels[7].feature = {};
  const Distance distance(1.25F);
  for (std::size_t count = 0; count <= 19; ++count) {
    const Feature centre = count == 5 ? voxels[3].feature : feature();
    std::vector<std::uint32_t> of(count);
    for (std::uint32_t& v : of) v = static_cast<std::uint32_t>(random() % voxels.size());
    std::vector<float> measured(count);
    distance.measure(centre, voxels.data(), of.data(), count, measured.data());
    for (std::size_t i = 0; i < count; ++i) {
      EXPECT_EQ(std::bit_cast<std::uint32_t>(measured[i]),
                std::bit_cast<std::uint32_t>(distance(centre, voxels[of[i]].feature)))
          << i << " of " << count;
    }
  }
}

}  // namespace
}  // namespace segserve::growth
