// SPDX-License-Identifier: Apache-2.0
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
#include "segserve/codec/labeled_cloud.hpp"
#include "segserve/codec/read_options.hpp"
#include "segserve/options.hpp"

namespace segserve::eval {

/// A method's result for a scene: one label and one supervoxel per point, 0 for none.
struct Partition {
  std::vector<std::uint32_t> labels;
  std::vector<std::uint32_t> supervoxels;
  std::size_t segment_count = 0;
  std::size_t supervoxel_count = 0;
  double ms = 0;  ///< Wall time of the segmentation alone.
};
using SegmentScene = std::function<absl::StatusOr<Partition>(const CloudView&)>;

/// Called after each scene.
using Progress = std::function<void(std::size_t done, std::size_t all)>;

/// The files of a folder that may be clouds with labels, sorted by name, without those in its subfolders: those of
/// codec::is_cloud_file without OBJ, which has no labels. INVALID_ARGUMENT if there is no such file or the path is not
/// a folder, NOT_FOUND if it does not exist.
absl::StatusOr<std::vector<std::filesystem::path>> scene_files(const std::filesystem::path& folder);

/// Reads a scene with ground truth (field "label", 0 = not scored) and degrades it. Points that are not finite have no
/// ground truth. `read` says what of the files is known better, such as their view. Errors are those of
/// `codec::load_cloud` and `degrade`, and INVALID_ARGUMENT without ground truth;
/// messages begin with the path.
absl::StatusOr<codec::LabeledCloud> load_scene(const std::filesystem::path& path, const Degradation& degradation,
                                               const codec::ReadOptions& read = {});

/// The scores of a partition; its arrays have one entry per point of the scene. INVALID_ARGUMENT if no point has ground
/// truth.
absl::StatusOr<MetricValues> score(const codec::LabeledCloud& scene, const Partition& partition);

/// A scene that could not be scored.
struct SceneFailure {
  std::string file;     ///< Its name, without the folder.
  absl::Status status;  ///< Why; the message begins with the path.
};

struct Evaluation {
  std::vector<SceneScores> scores;     ///< In the order of the files.
  std::vector<SceneFailure> failures;  ///< Likewise.
};

/// Scores every file, in order. A file that fails stops no other. `read` is that of load_scene.
Evaluation evaluate(const std::vector<std::filesystem::path>& files, const Degradation& degradation,
                    const SegmentScene& segment, const Progress& progress, const codec::ReadOptions& read = {});

/// Segments with segserve's own methods. One Segmenter serves all scenes.
SegmentScene with_options(const Options& options);

/// Sweeps the threshold over the merge trees of the scenes, which are not degraded. Stops at the first error, whose
/// message begins with the path: a threshold that was learned on fewer scenes would be another one.
absl::StatusOr<ThresholdSweep> learn_threshold(const std::vector<std::filesystem::path>& files, const Options& options,
                                               const Progress& progress, const codec::ReadOptions& read = {});

}  // namespace segserve::eval
