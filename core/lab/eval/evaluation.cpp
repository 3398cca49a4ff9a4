// SPDX-License-Identifier: Apache-2.0
#include "core/lab/eval/evaluation.hpp"

#include <algorithm>
#include <array>
#include <memory>
#include <ranges>
#include <string_view>
#include <system_error>
#include <utility>

#include "core/base/status_macros.hpp"
#include "core/base/status_text.hpp"
#include "core/lab/eval/boundary_scores.hpp"
#include "core/lab/eval/instance_scores.hpp"
#include "core/lab/eval/overlap_scores.hpp"
#include "core/lab/eval/scores.hpp"
#include "fmt/format.h"
#include "segserve/codec/cloud_file.hpp"
#include "segserve/codec/file_format.hpp"
#include "segserve/segment.hpp"

namespace segserve::eval {
namespace {

namespace fs = std::filesystem;

bool is_scene(const fs::directory_entry& entry) {
  const std::string path = entry.path().string();
  std::error_code ignored;
  return codec::has_readable_extension(path, codec::ReadableFor::kLabels) && entry.is_regular_file(ignored) &&
         codec::is_cloud_file(path);
}

absl::Status in_file(const fs::path& path, const absl::Status& status) { return with_prefix(path.string(), status); }

/// The value, or the error with the path before its message.
template <typename Value>
absl::StatusOr<Value> in_file(const fs::path& path, absl::StatusOr<Value> result) {
  if (!result.ok()) return in_file(path, result.status());
  return result;
}

bool has_objects(const Contingency& table) {
  return std::ranges::any_of(table.regions, [](const Part& region) { return region.label >= kFirstObjectLabel; });
}

void add_instance_metrics(const Contingency& segments, MetricValues& v) {
  if (const auto instances = instance_scores(segments)) {
    v[metric("instance.ap")] = instances->ap, v[metric("instance.ar")] = instances->ar;
    v[metric("instance.ap50")] = instances->ap50, v[metric("instance.ar50")] = instances->ar50;
    v[metric("instance.ap75")] = instances->ap75, v[metric("instance.ar75")] = instances->ar75;
  }
  if (const auto all = panoptic_scores(segments, Regions::kAll)) {
    v[metric("panoptic_all.pq")] = all->pq, v[metric("panoptic_all.rq")] = all->rq;
    v[metric("panoptic_all.sq")] = all->sq;
  }
  if (const auto objects = panoptic_scores(segments, Regions::kObjects)) {
    v[metric("panoptic_objects.pq")] = objects->pq, v[metric("panoptic_objects.rq")] = objects->rq;
    v[metric("panoptic_objects.sq")] = objects->sq;
  }
}

void add_overlap_metrics(const Contingency& segments, MetricValues& v) {
  const auto overlap = overlap_scores(segments);
  if (!overlap) return;
  v[metric("overlap_objects.precision")] = overlap->precision;
  v[metric("overlap_objects.recall")] = overlap->recall;
  v[metric("overlap_objects.f")] = overlap->f;
  v[metric("overlap_objects.objects_f75")] = overlap->objects_f75;
  const ObjectCounts counts = count_objects(segments);
  v[metric("object_counts.objects")] = counts.objects;
  v[metric("object_counts.over_segmented")] = counts.over_segmented;
  v[metric("object_counts.under_segmented")] = counts.under_segmented;
  v[metric("object_counts.missed")] = counts.missed;
}

absl::StatusOr<MetricValues> score_file(const fs::path& file, const Degradation& degradation,
                                        const SegmentScene& segment, const codec::ReadOptions& read) {
  ASSIGN_OR_RETURN(const auto scene, load_scene(file, degradation, read));
  ASSIGN_OR_RETURN(const Partition partition, in_file(file, segment(scene.cloud)));
  return in_file(file, score(scene, partition));
}

Partition partition_of(Segmentation segmentation) {
  return {std::move(segmentation.labels), std::move(segmentation.supervoxels), segmentation.segments,
          segmentation.tree.leaf_count(), segmentation.timings.total};
}

}  // namespace

absl::StatusOr<std::vector<fs::path>> scene_files(const fs::path& folder) {
  std::error_code error;
  const fs::file_status status = fs::status(folder, error);
  if (!fs::exists(status)) return absl::NotFoundError(fmt::format("there is no folder {}", folder.string()));
  if (!fs::is_directory(status)) return absl::InvalidArgumentError(fmt::format("{} is no folder", folder.string()));
  std::vector<fs::path> files;
  for (auto at = fs::directory_iterator(folder, error); !error && at != fs::directory_iterator(); at.increment(error)) {
    if (is_scene(*at)) files.push_back(at->path());
  }
  if (error) return absl::UnavailableError(fmt::format("cannot read {}: {}", folder.string(), error.message()));
  if (files.empty()) {
    return absl::InvalidArgumentError(fmt::format("{} has no cloud that can have labels: no file whose name ends in {}",
                                                  folder.string(),
                                                  codec::readable_extensions(codec::ReadableFor::kLabels)));
  }
  std::ranges::sort(files);
  return files;
}

absl::StatusOr<codec::LabeledCloud> load_scene(const fs::path& path, const Degradation& degradation,
                                               const codec::ReadOptions& read) {
  ASSIGN_OR_RETURN(codec::LabeledCloud scene, codec::load_cloud(path.string(), read));
  if (scene.label.empty()) {
    return in_file(path, absl::InvalidArgumentError("no ground truth: the file has no field \"label\""));
  }
  const Cloud& cloud = scene.cloud;
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    if (!is_finite(cloud.x[i], cloud.y[i], cloud.z[i])) scene.label[i] = 0;
  }
  const absl::Status status = degrade(scene, degradation, path.filename().string());
  if (!status.ok()) return in_file(path, status);
  if (std::ranges::all_of(scene.label, [](std::uint32_t label) { return label == 0; })) {
    return in_file(path, absl::InvalidArgumentError("no ground truth: no finite point has a label other than 0"));
  }
  return scene;
}

absl::StatusOr<MetricValues> score(const codec::LabeledCloud& scene, const Partition& partition) {
  ASSIGN_OR_RETURN(const Contingency segments, tabulate(scene.label, partition.labels));
  ASSIGN_OR_RETURN(const Contingency supervoxels, tabulate(scene.label, partition.supervoxels));

  MetricValues v;
  v[metric("supervoxels")] = static_cast<double>(partition.supervoxel_count);
  v[metric("segments")] = static_cast<double>(partition.segment_count);
  v[metric("ms")] = partition.ms;
  const Scores one = one_to_one_scores(segments);
  v[metric("one_to_one.wov")] = one.wov, v[metric("one_to_one.tp")] = one.tp;
  v[metric("one_to_one.fp")] = one.fp, v[metric("one_to_one.fn")] = one.fn;
  v[metric("one_to_one.f")] = one.f;
  const Scores all = paper_scores(segments, Regions::kAll);
  v[metric("paper_all.wov")] = all.wov, v[metric("paper_all.tp")] = all.tp;
  v[metric("paper_all.fp")] = all.fp, v[metric("paper_all.fn")] = all.fn;
  if (has_objects(segments)) {
    const Scores objects = paper_scores(segments, Regions::kObjects);
    v[metric("paper_objects.wov")] = objects.wov, v[metric("paper_objects.tp")] = objects.tp;
    v[metric("paper_objects.fp")] = objects.fp, v[metric("paper_objects.fn")] = objects.fn;
  }
  add_instance_metrics(segments, v);
  add_overlap_metrics(segments, v);
  if (const auto edges = boundary_scores(scene.label, partition.labels, scene.cloud.width, scene.cloud.height)) {
    v[metric("boundary.precision")] = edges->precision, v[metric("boundary.recall")] = edges->recall;
    v[metric("boundary.f")] = edges->f;
  }
  v[metric("variation_of_information")] = variation_of_information(segments);
  const SupervoxelScores quality = supervoxel_scores(supervoxels);
  v[metric("supervoxel_quality.achievable_accuracy")] = quality.achievable_accuracy;
  v[metric("supervoxel_quality.undersegmentation_error")] = quality.undersegmentation_error;
  v[metric("supervoxel_quality.boundary_recall")] =
      boundary_recall(scene.label, partition.supervoxels, scene.cloud.width, scene.cloud.height);
  return v;
}

Evaluation evaluate(const std::vector<fs::path>& files, const Degradation& degradation, const SegmentScene& segment,
                    const Progress& progress, const codec::ReadOptions& read) {
  Evaluation evaluation;
  for (const fs::path& file : files) {
    const std::string name = file.filename().string();
    auto values = score_file(file, degradation, segment, read);
    if (values.ok()) {
      evaluation.scores.push_back({name, *std::move(values)});
    } else {
      evaluation.failures.push_back({name, values.status()});
    }
    progress(evaluation.scores.size() + evaluation.failures.size(), files.size());
  }
  return evaluation;
}

SegmentScene with_options(const Options& options) {
  return [options, segmenter = std::make_shared<Segmenter>()](const CloudView& cloud) -> absl::StatusOr<Partition> {
    ASSIGN_OR_RETURN(Segmentation segmentation, segmenter->segment(cloud, options));
    return partition_of(std::move(segmentation));
  };
}

absl::StatusOr<ThresholdSweep> learn_threshold(const std::vector<fs::path>& files, const Options& options,
                                               const Progress& progress, const codec::ReadOptions& read) {
  Segmenter segmenter;
  ThresholdSweep sweep;
  for (const fs::path& file : files) {
    ASSIGN_OR_RETURN(const auto scene, load_scene(file, Degradation{}, read));
    ASSIGN_OR_RETURN(const Segmentation segmentation, in_file(file, segmenter.segment(scene.cloud, options)));
    ASSIGN_OR_RETURN(const Contingency supervoxels, in_file(file, tabulate(scene.label, segmentation.supervoxels)));
    const absl::Status status = sweep.add(supervoxels, segmentation.tree);
    if (!status.ok()) return in_file(file, status);
    progress(sweep.scenes(), files.size());
  }
  return sweep;
}

}  // namespace segserve::eval
