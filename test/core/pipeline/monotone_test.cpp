// SPDX-License-Identifier: Apache-2.0
// Cuts nest only if heights never fall. The border method promises more: weights never fall on the way from a
// supervoxel to the root. The tests run on every scene of OSD's learn set, if it is there, and on synthetic scenes.
#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>

#include "core/lab/synth/scene.hpp"
#include "segserve/codec/cloud_file.hpp"
#include "segserve/segment.hpp"

namespace segserve {
namespace {

/// How much weights may fall, because sums of evidence are rounded.
constexpr double kRounding = 1e-12;

void expect_monotone(const CloudView& cloud, Method method) {
  Options options;
  options.method = method;
  const MergeTree tree = segment(cloud, options)->tree;
  ASSERT_GT(tree.row_count(), 10U);
  ASSERT_TRUE(check(tree).ok());
  double height = 0;
  for (std::size_t row = 0; row < tree.row_count(); ++row) {
    height = std::max(height, tree.weight[row]);
    ASSERT_EQ(tree.height[row], height) << "row " << row;
    if (method != Method::kBorder) continue;
    for (const std::uint32_t child : {tree.left[row], tree.right[row]}) {
      if (child < tree.leaf_count()) continue;
      ASSERT_LE(tree.weight[child - tree.leaf_count()], tree.weight[row] + kRounding) << "row " << row;
    }
  }
}

class MonotoneTest : public testing::TestWithParam<Method> {};

TEST_P(MonotoneTest, OnEverySceneOfTheLearnSet) {
  const std::filesystem::path folder = std::filesystem::path(SEGSERVE_DATA_DIR) / "osd" / "learn";
  if (!std::filesystem::exists(folder)) GTEST_SKIP() << "no data in " << folder;
  std::size_t scenes = 0;
  for (const auto& file : std::filesystem::directory_iterator(folder)) {
    if (file.path().extension() != ".pcd") continue;
    SCOPED_TRACE(file.path().filename().string());
    const auto scene = codec::load_cloud(file.path().string());
    ASSERT_TRUE(scene.ok()) << scene.status();
    expect_monotone(scene->cloud, GetParam());
    ++scenes;
  }
  EXPECT_EQ(scenes, 45U);
}

TEST_P(MonotoneTest, OnTablesAndRooms) {
  for (const std::uint64_t seed : {1U, 2U, 3U, 4U}) {
    SCOPED_TRACE(seed);
    expect_monotone(synth::make_tabletop({.seed = seed, .objects = 16, .clutter = 0.9})->cloud, GetParam());
  }
  expect_monotone(synth::make_fused_room({.seed = 1, .points = 100000})->cloud, GetParam());
}

INSTANTIATE_TEST_SUITE_P(Methods, MonotoneTest,
                         testing::Values(Method::kBorder, Method::kLambda, Method::kLambdaConvex),
                         [](const auto& method) {
                           return method.param == Method::kBorder   ? "border"
                                  : method.param == Method::kLambda ? "lambda"
                                                                    : "lambda_convex";
                         });

}  // namespace
}  // namespace segserve
