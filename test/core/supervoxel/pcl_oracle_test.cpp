// Supervoxels must not be worse than those of PCL's SupervoxelClustering on the same frames.
#include <gtest/gtest.h>
#include <pcl/point_cloud.h>
#include <pcl/point_types.h>
#include <pcl/segmentation/supervoxel_clustering.h>

#include <filesystem>

#include "segserve/codec/cloud_file.hpp"
#include "segserve/eval/scores.hpp"
#include "segserve/pipeline/segment.hpp"
#include "segserve/synth/scene.hpp"

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

/// One id a point; PCL's 0, a point it left out, becomes a supervoxel of its own kind.
std::vector<std::uint32_t> pcl_supervoxels(const Cloud& cloud, const SupervoxelOptions& options, std::size_t& count) {
  const pcl::PointCloud<pcl::PointXYZRGBA>::Ptr points(
      new pcl::PointCloud<pcl::PointXYZRGBA>(cloud.width, cloud.height));
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    pcl::PointXYZRGBA& p = (*points)[i];
    p.x = cloud.x[i], p.y = cloud.y[i], p.z = cloud.z[i];
    p.rgba = cloud.rgb[i] | 0xff000000U;
  }
  points->is_dense = false;
  pcl::SupervoxelClustering<pcl::PointXYZRGBA> clustering(static_cast<float>(options.voxel_resolution),
                                                          static_cast<float>(options.seed_resolution));
  clustering.setUseSingleCameraTransform(cloud.view.kind == ViewKind::kCamera);
  clustering.setInputCloud(points);
  clustering.setColorImportance(static_cast<float>(options.color_weight));
  clustering.setSpatialImportance(static_cast<float>(options.spatial_weight));
  clustering.setNormalImportance(static_cast<float>(options.normal_weight));
  std::map<std::uint32_t, pcl::Supervoxel<pcl::PointXYZRGBA>::Ptr> clusters;
  clustering.extract(clusters);
  count = clusters.size();
  std::vector<std::uint32_t> ids;
  const pcl::PointCloud<pcl::PointXYZL>::Ptr labelled = clustering.getLabeledCloud();
  for (const pcl::PointXYZL& point : *labelled) ids.push_back(point.label);
  return ids;
}

void compare(const codec::LabelledCloud& frame, const Options& options, Sums& ours, Sums& pcl) {
  const Segmentation s = *segment(frame.cloud, options);
  ours.add(frame.label, s.supervoxels, s.tree.leaf_count());
  std::size_t count = 0;
  const std::vector<std::uint32_t> ids = pcl_supervoxels(frame.cloud, supervoxel_options(options), count);
  pcl.add(frame.label, ids, count);
}

void expect_not_worse(const Sums& ours, const Sums& pcl) {
  const double n = ours.frames;
  std::printf("supervoxels a frame: %.0f (PCL %.0f); achievable accuracy %.4f (%.4f); undersegmentation %.4f (%.4f)\n",
              ours.supervoxels / n, pcl.supervoxels / n, ours.accuracy / n, pcl.accuracy / n,
              ours.undersegmentation / n, pcl.undersegmentation / n);
  EXPECT_GE(ours.accuracy / n, pcl.accuracy / n - 0.0003);
  EXPECT_LE(ours.undersegmentation / n, pcl.undersegmentation / n + 0.0005);
  EXPECT_LE(ours.supervoxels, 1.35 * pcl.supervoxels) << "more supervoxels would make it too easy";
}

struct Resolution {
  const char* name;
  Options options;
};

class PclSupervoxels : public testing::TestWithParam<Resolution> {};

TEST_P(PclSupervoxels, AreNotBetterOnRealFrames) {
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

TEST_P(PclSupervoxels, AreNotBetterOnSyntheticFrames) {
  Sums ours, pcl;
  for (std::uint64_t seed = 1; seed <= 6; ++seed) {
    synth::SceneOptions options;
    options.seed = seed;
    synth::SyntheticScene scene = *synth::make_tabletop(options);
    codec::LabelledCloud frame;
    frame.cloud = std::move(scene.cloud);
    frame.label = std::move(scene.label);
    compare(frame, GetParam().options, ours, pcl);
  }
  expect_not_worse(ours, pcl);
}

INSTANTIATE_TEST_SUITE_P(Resolutions, PclSupervoxels,
                         testing::Values(Resolution{"paper", {.method = Method::kLambdaConvex}},
                                         Resolution{"fine", {.method = Method::kBorder}}),
                         [](const auto& param) { return param.param.name; });

}  // namespace
}  // namespace segserve
