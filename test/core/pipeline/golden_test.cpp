// SPDX-License-Identifier: Apache-2.0
// Checksums of whole results. They must be the same on every CPU (test/cpus runs this test on others). They may change
// only on purpose; then the commit and the CHANGELOG say so.
#include <gtest/gtest.h>

#include <bit>

#include "core/lab/synth/scene.hpp"
#include "segserve/segment.hpp"

namespace segserve {
namespace {

/// The FNV-1a hash of little-endian bytes.
class Checksum {
 public:
  void add(std::uint64_t value, int bytes) {
    for (int i = 0; i < bytes; ++i) hash_ = (hash_ ^ (value >> (8 * i) & 0xffU)) * 0x100000001b3ULL;
  }
  std::uint64_t value() const { return hash_; }

 private:
  std::uint64_t hash_ = 0xcbf29ce484222325ULL;
};

std::uint64_t checksum(const Segmentation& s) {
  Checksum sum;
  for (const std::uint32_t label : s.labels) sum.add(label, 4);
  for (const std::uint32_t id : s.supervoxels) sum.add(id, 4);
  for (std::size_t row = 0; row < s.tree.row_count(); ++row) {
    sum.add(s.tree.left[row], 4);
    sum.add(s.tree.right[row], 4);
    sum.add(std::bit_cast<std::uint64_t>(s.tree.weight[row]), 8);
  }
  return sum.value();
}

struct Golden {
  Method method;
  std::uint64_t camera, world;
};

class GoldenTest : public testing::TestWithParam<Golden> {};

TEST_P(GoldenTest, ATabletopInTheCameraView) {
  static const Cloud cloud = synth::make_tabletop({.seed = 5})->cloud;
  Options options;
  options.method = GetParam().method;
  EXPECT_EQ(checksum(*segment(cloud, options)), GetParam().camera);
}

TEST_P(GoldenTest, AFusedRoomInTheWorldView) {
  static const Cloud cloud = synth::make_fused_room({.seed = 5, .points = 150000})->cloud;
  Options options;
  options.method = GetParam().method;
  options.voxel_resolution = 0.02;
  options.seed_resolution = 0.15;
  EXPECT_EQ(checksum(*segment(cloud, options)), GetParam().world);
}

INSTANTIATE_TEST_SUITE_P(AllMethods, GoldenTest,
                         testing::Values(Golden{Method::kBorder, 0x9c10ad3afb85f897ULL, 0x266fe8d5f5739e89ULL},
                                         Golden{Method::kColor, 0x17f0761100154cb1ULL, 0xe114be74865460d6ULL},
                                         Golden{Method::kGeometry, 0xf07a6a3e50d16de6ULL, 0x6045136af17edbd0ULL},
                                         Golden{Method::kLambda, 0x904534e415183869ULL, 0x40ec2fc34ef2c85eULL},
                                         Golden{Method::kLambdaConvex, 0xd5d9104bfafabf77ULL, 0x402896fb17570151ULL},
                                         Golden{Method::kEqualization, 0xf938c99ee479b3eeULL, 0xcd77885cffd03f69ULL},
                                         Golden{Method::kEqualizationConvex, 0x568c7bccadac697fULL,
                                                0xfb093fceaae73099ULL},
                                         Golden{Method::kFixedLambda, 0x5817cfe37242e081ULL, 0x4dbc5271d356ac25ULL}),
                         [](const auto& param) {
                           std::string name(segserve::name(param.param.method));
                           std::erase(name, '-');
                           return name;
                         });

}  // namespace
}  // namespace segserve
