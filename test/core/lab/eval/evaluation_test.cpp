// SPDX-License-Identifier: Apache-2.0
#include "core/lab/eval/evaluation.hpp"

#include <gmock/gmock.h>

#include <fstream>

#include "core/lab/eval/boundary_scores.hpp"
#include "core/lab/eval/instance_scores.hpp"
#include "core/lab/eval/overlap_scores.hpp"
#include "core/lab/eval/scores.hpp"
#include "core/lab/synth/scene.hpp"
#include "segserve/codec/cloud_file.hpp"
#include "segserve/segment.hpp"

namespace segserve::eval {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;

class Folder : public testing::Test {
 protected:
  Folder() {
    const auto* test = testing::UnitTest::GetInstance()->current_test_info();
    folder_ = fs::path(testing::TempDir()) / (std::string("segserve-eval-") + test->name());
    fs::remove_all(folder_);
    fs::create_directories(folder_);
  }
  ~Folder() override { fs::remove_all(folder_); }

  synth::SyntheticScene add_scene(const std::string& name, std::uint64_t seed) {
    synth::SyntheticScene scene = *synth::make_tabletop({.seed = seed, .width = 160, .height = 120});
    EXPECT_TRUE(codec::save_cloud(folder_ / name, scene.cloud, scene.label).ok());
    return scene;
  }

  absl::StatusOr<std::vector<SceneScores>> run(const SegmentScene& segment, const Degradation& degradation = {}) {
    const Evaluation evaluation =
        evaluate(*scene_files(folder_), degradation, segment, [this](std::size_t done, std::size_t all) {
          progress_.push_back(static_cast<double>(done) / static_cast<double>(all));
        });
    if (!evaluation.failures.empty()) return evaluation.failures.front().status;
    return evaluation.scores;
  }

  fs::path folder_;
  std::vector<double> progress_;
};

TEST_F(Folder, ScenesAreTheCloudsInItByName) {
  for (const char* name : {"b.pcd", "a.PLY", "c.txt", "pcd", "e.obj", "e.OBJ.gz", "f.las.zst", "g.npz"}) {
    std::ofstream(folder_ / name) << "x";
  }
  std::ofstream(folder_ / "h.txt") << "x y z label\n0 0 1 1\n0 1 1 10\n";
  fs::create_directories(folder_ / "d.pcd");
  EXPECT_THAT(*scene_files(folder_), testing::ElementsAre(folder_ / "a.PLY", folder_ / "b.pcd", folder_ / "f.las.zst",
                                                          folder_ / "g.npz", folder_ / "h.txt"));
}

TEST_F(Folder, EveryFormatWithLabelsIsScoredAlike) {
  for (const char* name : {"1.pcd", "1.ply", "1.las", "1.csv", "1.xyz", "1.npy"}) add_scene(name, 1);
  const auto look = [](const CloudView& cloud) -> absl::StatusOr<Partition> {
    const std::vector<std::uint32_t> one(cloud.size(), 1);
    return Partition{.labels = one, .supervoxels = one};
  };
  const auto rows = run(look);
  ASSERT_TRUE(rows.ok()) << rows.status();
  ASSERT_EQ(rows->size(), 6U);
  for (const SceneScores& row : *rows) {
    EXPECT_EQ(row.values[metric("one_to_one.wov")], rows->front().values[metric("one_to_one.wov")]) << row.file;
    EXPECT_EQ(row.values[metric("object_counts.objects")], rows->front().values[metric("object_counts.objects")]);
  }
}

TEST_F(Folder, TheViewIsTheOneThatWasGiven) {
  add_scene("1.pcd", 1);
  ASSERT_EQ(load_scene(folder_ / "1.pcd", Degradation{})->cloud.view.kind, ViewKind::kCamera);
  std::vector<View> views;
  const auto look = [&](const CloudView& cloud) -> absl::StatusOr<Partition> {
    views.push_back(cloud.view);
    return absl::UnavailableError("seen");
  };
  evaluate(*scene_files(folder_), {}, look, [](std::size_t, std::size_t) {}, {.view = View::world(1, 2, 3)});
  ASSERT_EQ(views.size(), 1U);
  EXPECT_EQ(views[0].kind, ViewKind::kWorld);
  EXPECT_EQ(views[0].sensor->y(), 2);
}

TEST_F(Folder, FaultsOfTheFolderAreTold) {
  EXPECT_THAT(std::string(scene_files(folder_).status().message()), HasSubstr("has no cloud that can have labels"));
  EXPECT_EQ(scene_files(folder_ / "absent").status().code(), absl::StatusCode::kNotFound);
  std::ofstream(folder_ / "file") << "x";
  EXPECT_THAT(std::string(scene_files(folder_ / "file").status().message()), HasSubstr("is no folder"));
}

TEST_F(Folder, ScoresAreThoseOfTheSegmentation) {
  const synth::SyntheticScene first = add_scene("1.pcd", 1);
  add_scene("2.pcd", 2);
  const auto rows = run(with_options({}));
  ASSERT_TRUE(rows.ok()) << rows.status();
  ASSERT_EQ(rows->size(), 2U);
  EXPECT_THAT(progress_, testing::ElementsAre(0.5, 1.0));
  EXPECT_EQ((*rows)[0].file, "1.pcd");

  const Segmentation expected = *segment(first.cloud, {});
  const Contingency table = *tabulate(first.label, expected.labels);
  const MetricValues& v = (*rows)[0].values;
  EXPECT_EQ(v[metric("supervoxels")], expected.tree.leaf_count());
  EXPECT_EQ(v[metric("segments")], expected.segments);
  EXPECT_EQ(v[metric("one_to_one.wov")], one_to_one_scores(table).wov);
  EXPECT_EQ(v[metric("paper_all.tp")], paper_scores(table, Regions::kAll).tp);
  EXPECT_EQ(v[metric("paper_objects.wov")], paper_scores(table, Regions::kObjects).wov);
  EXPECT_EQ(v[metric("instance.ap75")], instance_scores(table)->ap75);
  EXPECT_EQ(v[metric("panoptic_all.rq")], panoptic_scores(table, Regions::kAll)->rq);
  EXPECT_EQ(v[metric("panoptic_objects.pq")], panoptic_scores(table, Regions::kObjects)->pq);
  EXPECT_EQ(v[metric("overlap_objects.precision")], overlap_scores(table)->precision);
  EXPECT_EQ(v[metric("object_counts.over_segmented")], count_objects(table).over_segmented);
  EXPECT_EQ(v[metric("boundary.f")], boundary_scores(first.label, expected.labels, 160, 120)->f);
  EXPECT_EQ(v[metric("supervoxel_quality.achievable_accuracy")],
            supervoxel_scores(*tabulate(first.label, expected.supervoxels)).achievable_accuracy);
  EXPECT_GT(*v[metric("supervoxel_quality.boundary_recall")], 0.5);
  EXPECT_GT(*v[metric("ms")], 0);
  EXPECT_EQ(*mean(*rows)[metric("segments")], (*v[metric("segments")] + *(*rows)[1].values[metric("segments")]) / 2);
}

TEST_F(Folder, AFileThatFailsStopsNoOther) {
  add_scene("1.pcd", 1);
  std::ofstream(folder_ / "2.pcd") << "no cloud";
  add_scene("3.pcd", 3);
  std::vector<std::size_t> progress;
  const Evaluation evaluation = evaluate(*scene_files(folder_), {}, with_options({}),
                                         [&](std::size_t done, std::size_t) { progress.push_back(done); });
  EXPECT_THAT(progress, testing::ElementsAre(1, 2, 3));
  ASSERT_EQ(evaluation.scores.size(), 2U);
  EXPECT_EQ(evaluation.scores[1].file, "3.pcd");
  ASSERT_EQ(evaluation.failures.size(), 1U);
  EXPECT_EQ(evaluation.failures[0].file, "2.pcd");
  EXPECT_THAT(std::string(evaluation.failures[0].status.message()), testing::StartsWith((folder_ / "2.pcd").string()));
}

TEST_F(Folder, GroundTruthItselfScoresPerfectly) {
  const synth::SyntheticScene scene = add_scene("1.pcd", 3);
  const auto truth = [&](const CloudView&) -> absl::StatusOr<Partition> {
    return Partition{.labels = scene.label, .supervoxels = scene.label};
  };
  const MetricValues v = run(truth)->front().values;
  for (const std::size_t m :
       {metric("one_to_one.wov"), metric("one_to_one.f"), metric("paper_all.tp"), metric("paper_objects.wov"),
        metric("instance.ap"), metric("instance.ar75"), metric("panoptic_all.pq"), metric("panoptic_objects.sq"),
        metric("overlap_objects.f"), metric("overlap_objects.objects_f75"), metric("boundary.f"),
        metric("supervoxel_quality.achievable_accuracy"), metric("supervoxel_quality.boundary_recall")}) {
    EXPECT_DOUBLE_EQ(*v[m], 1) << kMetrics[m].name;
  }
  EXPECT_EQ(v[metric("variation_of_information")], 0);
  EXPECT_GT(v[metric("object_counts.objects")], 0);
  EXPECT_EQ(v[metric("object_counts.over_segmented")], 0);
  EXPECT_EQ(v[metric("object_counts.under_segmented")], 0);
  EXPECT_EQ(v[metric("object_counts.missed")], 0);
}

TEST_F(Folder, AMethodSeesTheDegradedScene) {
  add_scene("1.pcd", 4);
  std::size_t finite = 0, all = 0;
  const auto look = [&](const CloudView& cloud) -> absl::StatusOr<Partition> {
    for (std::size_t i = 0; i < cloud.size(); ++i) finite += is_finite(cloud.x[i], cloud.y[i], cloud.z[i]) ? 1U : 0U;
    all += cloud.size();
    EXPECT_FALSE(cloud.has_color());
    return Partition{std::vector<std::uint32_t>(cloud.size(), 1), std::vector<std::uint32_t>(cloud.size(), 1), 1, 1, 0};
  };
  ASSERT_TRUE(run(look, {.keep = 0.25, .color = false}).ok());
  EXPECT_LT(finite, all * 0.27);
  EXPECT_GT(finite, 0U);
}

TEST_F(Folder, AFusedRoomHasNoBoundaryRecall) {
  const synth::SyntheticScene room = *synth::make_fused_room({.seed = 1, .points = 20'000});
  ASSERT_TRUE(codec::save_cloud(folder_ / "room.pcd", room.cloud, room.label).ok());
  Options coarse;  // as the points are
  coarse.voxel_resolution = 0.06;
  coarse.seed_resolution = 0.3;
  const auto rows = run(with_options(coarse));
  ASSERT_TRUE(rows.ok()) << rows.status();
  EXPECT_FALSE(rows->front().values[metric("supervoxel_quality.boundary_recall")]);
  EXPECT_GT(*rows->front().values[metric("one_to_one.wov")], 0.3);
}

TEST_F(Folder, AScenesFaultsBeginWithItsPath) {
  const synth::SyntheticScene scene = *synth::make_tabletop({.width = 64, .height = 48});
  const std::string path = folder_ / "x.pcd";
  const auto message = [&] { return std::string(run(with_options({})).status().message()); };
  ASSERT_TRUE(codec::save_cloud(path, scene.cloud, {}).ok());
  EXPECT_EQ(message(), path + ": no ground truth: the file has no field \"label\"");
  ASSERT_TRUE(codec::save_cloud(path, scene.cloud, std::vector<std::uint32_t>(scene.label.size(), 0)).ok());
  EXPECT_EQ(message(), path + ": no ground truth: no finite point has a label other than 0");
  std::ofstream(path) << "garbage";
  EXPECT_THAT(message(), testing::StartsWith(path + ": "));
}

TEST_F(Folder, TheLearntThresholdIsTheBestOnIt) {
  add_scene("1.pcd", 6);
  add_scene("2.pcd", 7);
  Options options;
  options.method = Method::kLambdaConvex;
  const auto sweep = learn_threshold(*scene_files(folder_), options, [](std::size_t, std::size_t) {});
  ASSERT_TRUE(sweep.ok()) << sweep.status();
  EXPECT_EQ(sweep->scenes(), 2U);
  for (const std::size_t i : {sweep->best(), std::size_t{50}}) {
    options.threshold = ThresholdSweep::threshold(i);
    EXPECT_NEAR(*mean(*run(with_options(options)))[metric("one_to_one.tp")], sweep->tp(i), 1e-12);
    EXPECT_LE(sweep->tp(i), sweep->tp(sweep->best()));
  }
}

}  // namespace
}  // namespace segserve::eval
