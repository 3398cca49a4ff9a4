// SPDX-License-Identifier: Apache-2.0
//
// Supervoxels must not be worse than those of PCL's SupervoxelClustering on the same frames.
#include <gtest/gtest.h>

#include <filesystem>

#include "core/lab/eval/scores.hpp"
#include "core/lab/synth/scene.hpp"
#include "core/pcl_adapter/peer/pcl_peer.hpp"
#include "segserve/codec/cloud_file.hpp"
#include "segserve/segment.hpp"

namespace segserve {
namespace {

struct Sums {
  double accuracy = 0, undersegmentation = 0, supervoxels = 0, frames = 0;

  void add(std::span<const std::uint32_t> truth, std::span<const std::uint32_t> ids, std::size_t count) {
    const eval::SupervoxelScores s = eval::supervoxel_scores(*eval::tabulate(truth, ids));
    accuracy += s.achievable_accuracy;
    undersegmentation += s.undersegmentation_error;
    supervoxels += static_cast<double>(count);
    ++frames;
  }
};

void compare(const codec::LabeledCloud& frame, const Options& options, Sums& ours, Sums& pcl) {
  const Segmentation s = *segment(frame.cloud, options);
  ours.add(frame.label, s.supervoxels, s.tree.leaf_count());
  const pcl_peer::PclCloud cloud(frame.cloud);
  const pcl_peer::PclSupervoxels theirs(cloud, pcl_peer::same_as(options));
  // The points that PCL left out have label 0, which counts as a supervoxel.
  pcl.add(frame.label, theirs.labels(), theirs.size());
}

void expect_not_worse(const Sums& ours, const Sums& pcl) {
  const double n = ours.frames;
  std::printf("supervoxels a frame: %.0f (PCL %.0f); achievable accuracy %.4f (%.4f); undersegmentation %.4f (%.4f)\n",
              ours.supervoxels / n, pcl.supervoxels / n, ours.accuracy / n, pcl.accuracy / n,
              ours.undersegmentation / n, pcl.undersegmentation / n);
  EXPECT_GE(ours.accuracy / n, pcl.accuracy / n - 0.0003);
  EXPECT_LE(ours.undersegmentation / n, pcl.undersegmentation / n + 0.0005);
  EXPECT_LE(ours.supervoxels, 1.35 * pcl.supervoxels) << "more supervoxels would be better for that reason alone";
}

struct Resolution {
  const char* name;
  Options options;
};

class PclSupervoxels : public testing::TestWithParam<Resolution> {};

TEST_P(PclSupervoxels, AreNotBetterThanOursOnRealFrames) {
  const std::filesystem::path folder = std::filesystem::path(SEGSERVE_DATA_DIR) / "osd/learn";
  if (!std::filesystem::exists(folder)) GTEST_SKIP() << "no OSD scenes in " << folder;
  Sums ours, pcl;
  for (int scene = 0; scene < 45; scene += 3) {
    const auto frame = codec::load_cloud(folder / ("learn" + std::to_string(scene) + ".pcd"));
    ASSERT_TRUE(frame.ok()) << frame.status();
    compare(*frame, GetParam().options, ours, pcl);
  }
  expect_not_worse(ours, pcl);
}

TEST_P(PclSupervoxels, AreNotBetterThanOursOnSyntheticFrames) {
  Sums ours, pcl;
  for (std::uint64_t seed = 1; seed <= 6; ++seed) {
    synth::SceneOptions options;
    options.seed = seed;
    synth::SyntheticScene scene = *synth::make_tabletop(options);
    codec::LabeledCloud frame;
    frame.cloud = std::move(scene.cloud);
    frame.label = std::move(scene.label);
    compare(frame, GetParam().options, ours, pcl);
  }
  expect_not_worse(ours, pcl);
}

INSTANTIATE_TEST_SUITE_P(
    Resolutions, PclSupervoxels,
    testing::Values(Resolution{"paper", {.method = Method::kLambdaConvex}},
                    Resolution{"fine",
                               {.method = Method::kBorder, .voxel_resolution = 0.0075, .seed_resolution = 0.03}}),
    [](const auto& param) { return param.param.name; });

}  // namespace
}  // namespace segserve
