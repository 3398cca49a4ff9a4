#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "core/lab/eval/degrade.hpp"
#include "core/lab/eval/partition_metrics.hpp"
#include "core/lab/eval/threshold_sweep.hpp"
#include "segserve/cloud.hpp"
#include "segserve/codec/labelled_cloud.hpp"
#include "segserve/options.hpp"

namespace segserve::eval {

/// What a method made of a scene: one label and one supervoxel a point, 0 = none.
struct Partition {
  std::vector<std::uint32_t> labels;
  std::vector<std::uint32_t> supervoxels;
  std::size_t segment_count = 0;
  std::size_t supervoxel_count = 0;
  double ms = 0;  ///< wall time of the segmentation alone
};
using SegmentScene = std::function<absl::StatusOr<Partition>(const CloudView&)>;

/// Called after each scene.
using Progress = std::function<void(std::size_t done, std::size_t all)>;

/// The .pcd and .ply files of a folder, by name; not those of folders in it. INVALID_ARGUMENT if there is none or it is
/// no folder, NOT_FOUND if it does not exist.
absl::StatusOr<std::vector<std::filesystem::path>> scene_files(const std::filesystem::path& folder);

/// Reads a scene with ground truth (field "label", 0 = not scored) and degrades it. Points that are not finite have no
/// ground truth. Errors begin with the path: as `codec::load_cloud` and `degrade`; INVALID_ARGUMENT without ground
/// truth.
absl::StatusOr<codec::LabelledCloud> load_scene(const std::filesystem::path& path, const Degradation& degradation);

/// Scores of a partition of a scene, both of its size. INVALID_ARGUMENT if no point has ground truth.
absl::StatusOr<MetricValues> score(const codec::LabelledCloud& scene, const Partition& partition);

/// One row a file, in order. The first error ends it, its message begins with the path.
absl::StatusOr<std::vector<SceneScores>> evaluate(const std::vector<std::filesystem::path>& files,
                                                  const Degradation& degradation, const SegmentScene& segment,
                                                  const Progress& progress);

/// Segments with our own methods; one Segmenter serves all scenes.
SegmentScene with_options(const Options& options);

/// Sweeps the threshold over the trees of scenes, as they are.
absl::StatusOr<ThresholdSweep> learn_threshold(const std::vector<std::filesystem::path>& files, const Options& options,
                                               const Progress& progress);

}  // namespace segserve::eval
