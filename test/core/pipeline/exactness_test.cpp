// SPDX-License-Identifier: Apache-2.0
// Properties that hold exactly, for every method (docs/decisions/0002-exactness.md).
#include <gtest/gtest.h>

#include <algorithm>
#include <numeric>
#include <random>

#include "core/lab/synth/scene.hpp"
#include "segserve/segment.hpp"
#include "test/core/support/clouds.hpp"

namespace segserve {
namespace {

const Cloud& tabletop() {
  static const Cloud cloud = [] {
    synth::SceneOptions options;
    options.seed = 11;
    options.width = 320;
    options.height = 240;
    return synth::make_tabletop(options)->cloud;
  }();
  return cloud;
}

Options with(Method method) {
  Options options;
  options.method = method;
  return options;
}

void expect_same(const Segmentation& a, const Segmentation& b) {
  EXPECT_EQ(a.labels, b.labels);
  EXPECT_EQ(a.supervoxels, b.supervoxels);
  EXPECT_TRUE(a.tree == b.tree);
  EXPECT_EQ(a.segments, b.segments);
  EXPECT_EQ(a.lambda, b.lambda);
}

class Exactness : public testing::TestWithParam<Method> {};

TEST_P(Exactness, EveryFinitePointHasOneLabelAndNoOtherHasAny) {
  const Segmentation s = *segment(tabletop(), with(GetParam()));
  ASSERT_EQ(s.labels.size(), tabletop().size());
  std::vector<std::size_t> size(s.segments + 1);
  for (std::size_t i = 0; i < s.labels.size(); ++i) {
    const bool finite = is_finite(tabletop().x[i], tabletop().y[i], tabletop().z[i]);
    ASSERT_EQ(s.labels[i] != 0, finite);
    ASSERT_EQ(s.supervoxels[i] != 0, finite);
    ASSERT_LE(s.labels[i], s.segments);
    ++size[s.labels[i]];
  }
  EXPECT_TRUE(std::is_sorted(size.begin() + 1, size.end(), std::greater<>()))
      << "segments are numbered by descending size";
  EXPECT_GT(size.back(), 0U) << "the numbers have no gaps";
  EXPECT_GT(s.segments, 2U);
}

TEST_P(Exactness, ThreadsChangeNothing) {
  Options options = with(GetParam());
  const Segmentation one = *segment(tabletop(), options);
  for (const std::uint32_t threads : {2U, 5U}) {
    options.threads = threads;
    expect_same(one, *segment(tabletop(), options));
  }
}

TEST_P(Exactness, AnotherFrameInBetweenChangesNothing) {
  Segmenter segmenter;
  const Segmentation first = *segmenter.segment(tabletop(), with(GetParam()));
  ASSERT_TRUE(segmenter.segment(test::random_cloud(3000, 1, 2, View::camera()), with(GetParam())).ok());
  expect_same(first, *segmenter.segment(tabletop(), with(GetParam())));
}

/// A floor in waves, of side x side voxels of 1 cm with one point in each.
Cloud floor_of_voxels(std::uint32_t side) {
  constexpr float kEdge = 0.01F;
  Cloud cloud;
  cloud.resize(std::size_t{side} * side, true);
  cloud.width = side, cloud.height = side;
  cloud.view = View::world(1, 1, 10);
  for (std::uint32_t i = 0; i < cloud.size(); ++i) {
    cloud.x[i] = kEdge * (static_cast<float>(i % side) + 0.5F);
    cloud.y[i] = kEdge * (static_cast<float>(i / side) + 0.5F);
    cloud.z[i] = kEdge * (0.5F + static_cast<float>(i / 97 % 2));
    cloud.rgb[i] = i / 1000 * 77;
  }
  return cloud;
}

TEST_P(Exactness, ReleasingTheBuffersOfALargeFrameChangesNothing) {
  constexpr std::uint32_t kSide = 505;  // These are more voxels than a segmenter keeps buffers for.
  Options options = with(GetParam());
  options.voxel_resolution = 0.01;
  options.seed_resolution = 0.4;
  const Cloud large = floor_of_voxels(kSide);
  Segmenter segmenter;
  const Segmentation first = *segmenter.segment(large, options);
  EXPECT_EQ(first.voxels, kSide * kSide);
  expect_same(*segment(tabletop(), with(GetParam())), *segmenter.segment(tabletop(), with(GetParam())));
  expect_same(first, *segmenter.segment(large, options));
}

TEST_P(Exactness, PermutingThePointsOnlyPermutesTheLabels) {
  const Segmentation s = *segment(tabletop(), with(GetParam()));
  std::vector<std::uint32_t> order(tabletop().size());
  std::iota(order.begin(), order.end(), 0U);
  std::ranges::shuffle(order, std::mt19937(3));
  const Segmentation p = *segment(test::permuted(tabletop(), order), with(GetParam()));
  for (std::size_t i = 0; i < order.size(); ++i) {
    ASSERT_EQ(p.labels[i], s.labels[order[i]]);
    ASSERT_EQ(p.supervoxels[i], s.supervoxels[order[i]]);
  }
  EXPECT_TRUE(p.tree == s.tree);
}

TEST_P(Exactness, ACutAtDRegionsReturnsExactlyDOrM) {
  const Segmentation s = *segment(tabletop(), with(GetParam()));
  const auto m = static_cast<std::uint32_t>(s.tree.leaf_count());
  EXPECT_TRUE(check(s.tree).ok()) << check(s.tree);
  for (const std::uint32_t d : {1U, 2U, 7U, m - 1, m, m + 5}) {
    EXPECT_EQ(cut_to_regions(s.tree, d)->segments, std::min(d, m));
    Options options = with(GetParam());
    options.regions = d;
    if (d == 7) {
      const Segmentation direct = *segment(tabletop(), options);
      EXPECT_EQ(direct.labels, *label_points(s.supervoxels, *cut_to_regions(s.tree, d)));
    }
  }
}

TEST_P(Exactness, ACutOfTheTreeEqualsSegmentingWithThatThreshold) {
  Options options = with(GetParam());
  const Segmentation s = *segment(tabletop(), options);
  for (const double threshold : {0.0, 0.05, 0.3, 1.0}) {
    options.threshold = threshold;
    EXPECT_EQ(segment(tabletop(), options)->labels, *label_points(s.supervoxels, *cut_at_threshold(s.tree, threshold)));
  }
}

INSTANTIATE_TEST_SUITE_P(AllMethods, Exactness, testing::ValuesIn(all_methods().begin(), all_methods().end()),
                         [](const auto& param) {
                           std::string name(segserve::name(param.param));
                           std::erase(name, '-');
                           return name;
                         });

TEST(Exactness, PointsThatAreNotFiniteChangeNothing) {
  Cloud sparse = test::random_cloud(4000, 0.5F, 1, View::camera());
  const Segmentation before = *segment(sparse, {});
  for (int i = 0; i < 100; ++i) test::add(sparse, std::numeric_limits<float>::quiet_NaN(), 1, 1, 0xffffff);
  const Segmentation after = *segment(sparse, {});
  EXPECT_TRUE(before.tree == after.tree);
  EXPECT_EQ(after.finite_points, 4000U);
}

}  // namespace
}  // namespace segserve
