// SPDX-License-Identifier: Apache-2.0
#include "core/lab/eval/thumbnails.hpp"

#include <gmock/gmock.h>
#include <png.h>

#include <filesystem>

#include "core/lab/synth/scene.hpp"
#include "segserve/codec/cloud_file.hpp"
#include "test/temporary_path.hpp"

namespace segserve::eval {
namespace {

using testing::ElementsAre;
using Labels = std::vector<std::uint32_t>;

TEST(WorstScenes, AreThoseWithTheSmallestOverlapOfObjects) {
  std::vector<SceneScores> scenes{{"a", {}}, {"b", {}}, {"c", {}}, {"d", {}}};
  scenes[0].values[metric("paper_objects.wov")] = 0.9;
  scenes[2].values[metric("paper_objects.wov")] = 0.5;
  scenes[3].values[metric("paper_objects.wov")] = 0.9;
  EXPECT_THAT(worst_scenes(scenes, 2), ElementsAre("c", "a"));
  EXPECT_THAT(worst_scenes(scenes, 9), ElementsAre("c", "a", "d"));
  EXPECT_THAT(worst_scenes(scenes, 0), ElementsAre());
}

TEST(MatchingLabels, AreThoseOfTheRegionsThatSegmentsMatch) {
  // Segment 7 matches region 10, segment 8 has half of region 1, segment 9 the other; a point is not scored.
  EXPECT_THAT(matching_labels(Labels{1, 1, 10, 10, 10, 0}, Labels{8, 9, 7, 7, 7, 7}),
              ElementsAre(11, 12, 10, 10, 10, 10));
  EXPECT_THAT(matching_labels(Labels{1, 1, 1}, Labels{0, 4, 4}), ElementsAre(0, 1, 1));
  EXPECT_THAT(matching_labels(Labels{0, 0}, Labels{4, 0}), ElementsAre(1, 0));
}

/// Width and height of a PNG.
std::pair<std::uint32_t, std::uint32_t> size_of(const std::string& bytes) {
  png_image png{};
  png.version = PNG_IMAGE_VERSION;
  EXPECT_NE(png_image_begin_read_from_memory(&png, bytes.data(), bytes.size()), 0) << png.message;
  png_image_free(&png);
  return {png.width, png.height};
}

TEST(MakeThumbnails, ShowsGroundTruthAndSegments) {
  const std::string path = test::temporary_path("scene.pcd");
  const synth::SyntheticScene scene = *synth::make_tabletop({.width = 640, .height = 480});
  ASSERT_TRUE(codec::save_cloud(path, scene.cloud, scene.label).ok());
  const auto right = [&](const CloudView&) -> absl::StatusOr<Partition> {
    return Partition{.labels = scene.label, .supervoxels = {}};
  };
  const auto one = [&](const CloudView& cloud) -> absl::StatusOr<Partition> {
    return Partition{.labels = Labels(cloud.size(), 1), .supervoxels = {}};
  };
  const auto pictures = make_thumbnails(path, {}, right);
  ASSERT_TRUE(pictures.ok()) << pictures.status();
  EXPECT_EQ(pictures->file, std::filesystem::path(path).filename().string());
  EXPECT_EQ(pictures->truth, pictures->segments);
  EXPECT_EQ(size_of(pictures->truth), std::pair(320U, 240U));
  EXPECT_NE(make_thumbnails(path, {}, one)->segments, pictures->segments);

  const auto fails = [](const CloudView&) -> absl::StatusOr<Partition> { return absl::InternalError("no"); };
  EXPECT_EQ(make_thumbnails(path, {}, fails).status().message(), path + ": no");
  std::filesystem::remove(path);
}

}  // namespace
}  // namespace segserve::eval
