// SPDX-License-Identifier: Apache-2.0
#include "proto/wire/result_message.hpp"

#include <cstddef>
#include <optional>
#include <utility>
#include <vector>

#include "core/base/status_macros.hpp"
#include "fmt/format.h"
#include "proto/wire/cloud_message.hpp"
#include "proto/wire/integers_message.hpp"
#include "proto/wire/options_message.hpp"
#include "proto/wire/prompts_message.hpp"
#include "proto/wire/result_warnings.hpp"
#include "proto/wire/segment_message.hpp"
#include "proto/wire/status_message.hpp"
#include "proto/wire/track_message.hpp"
#include "proto/wire/tree_message.hpp"

namespace segserve::wire {
namespace {

v1::SupportPlane support_plane_message(const SupportPlane& plane) {
  v1::SupportPlane message;
  message.set_points(plane.points);
  message.set_normal_x(plane.normal.x());
  message.set_normal_y(plane.normal.y());
  message.set_normal_z(plane.normal.z());
  message.set_offset(plane.offset);
  return message;
}

SupportPlane read_support_plane(const v1::SupportPlane& message) {
  return {.normal = {message.normal_x(), message.normal_y(), message.normal_z()},
          .offset = message.offset(),
          .points = message.points()};
}

v1::Vector3 vector_message(const Eigen::Vector3d& v) {
  v1::Vector3 message;
  message.set_x(v.x());
  message.set_y(v.y());
  message.set_z(v.z());
  return message;
}

v1::Placement placement_message(const codec::Placement& placement) {
  v1::Placement message;
  *message.mutable_scale() = vector_message(placement.scale);
  *message.mutable_offset() = vector_message(placement.offset);
  return message;
}

/// The placement of a message, or nullopt if it is not one.
std::optional<codec::Placement> read_placement(const v1::Placement& message) {
  const codec::Placement placement{{message.scale().x(), message.scale().y(), message.scale().z()},
                                   {message.offset().x(), message.offset().y(), message.offset().z()}};
  const Eigen::Vector3d magnitude = placement.scale.cwiseAbs();
  const bool good = placement.scale.allFinite() && placement.offset.allFinite() && magnitude.minCoeff() > 0 &&
                    magnitude.minCoeff() == magnitude.maxCoeff();
  return good ? std::optional(placement) : std::nullopt;
}

void fill_timings(const CallTimings& call, const StageTimings& stages, v1::Timings& timings) {
  timings.set_queue_ms(call.queue);
  timings.set_decode_ms(call.decode);
  timings.set_voxels_ms(stages.voxels);
  timings.set_normals_ms(stages.normals);
  timings.set_supervoxels_ms(stages.supervoxels);
  timings.set_graph_ms(stages.graph);
  timings.set_merging_ms(stages.merging);
  timings.set_labels_ms(stages.labels);
  timings.set_segments_ms(stages.segments);
  timings.set_tracking_ms(stages.tracking);
}

v1::Resolution resolution_message(const Resolution& resolution) {
  v1::Resolution message;
  message.set_voxel_resolution(resolution.voxel);
  message.set_seed_resolution(resolution.seed);
  message.set_reason(std::string(name(resolution.reason)));
  if (resolution.noise_depth) message.set_noise_depth(*resolution.noise_depth);
  return message;
}

void fill_summary(const Result& result, v1::ResultSummary& summary) {
  const Segmentation& segmentation = result.segmentation;
  summary.set_points(result.points);
  summary.set_finite_points(segmentation.finite_points);
  summary.set_segmented_points(segmentation.segmented_points);
  if (segmentation.support_plane) *summary.mutable_support_plane() = support_plane_message(*segmentation.support_plane);
  summary.set_voxels(segmentation.voxels);
  summary.set_supervoxels(result.supervoxels);
  summary.set_segments(segmentation.segments);
  summary.set_method(to_message(result.method));
  if (segmentation.threshold) summary.set_threshold(*segmentation.threshold);
  if (result.regions) summary.set_regions(*result.regions);
  summary.set_lambda(segmentation.lambda);
  *summary.mutable_resolution() = resolution_message(segmentation.resolution);
  *summary.mutable_view() = to_message(result.view);
  summary.set_view_rule(result.view_rule);
  for (const codec::Warning& warning : result.warnings) {
    v1::Warning& message = *summary.add_warnings();
    message.set_reason(std::string(name(warning.reason)));
    message.set_message(warning.message);
  }
  if (!result.placement.is_identity()) *summary.mutable_placement() = placement_message(result.placement);
  summary.set_server_version(result.server_version);
  summary.set_options_hash(result.options_hash);
  fill_timings(result.timings, segmentation.timings, *summary.mutable_timings());
}

void read_timings(const v1::Timings& from, CallTimings& call, StageTimings& stages) {
  call = {from.queue_ms(), from.decode_ms(), from.encode_ms(), from.total_ms()};
  stages.voxels = from.voxels_ms();
  stages.normals = from.normals_ms();
  stages.supervoxels = from.supervoxels_ms();
  stages.graph = from.graph_ms();
  stages.merging = from.merging_ms();
  stages.labels = from.labels_ms();
  stages.segments = from.segments_ms();
  stages.tracking = from.tracking_ms();
  stages.total = stages.voxels + stages.normals + stages.supervoxels + stages.graph + stages.merging + stages.labels +
                 stages.tracking + stages.segments;
}

absl::Status check_numbers(const v1::ResultSummary& summary, std::size_t points) {
  if (summary.points() != points) {
    return malformed(fmt::format("the result has {} points, but the cloud has {}", summary.points(), points));
  }
  if (summary.finite_points() > points || summary.segmented_points() > summary.finite_points() ||
      summary.support_plane().points() > summary.finite_points() - summary.segmented_points() ||
      summary.supervoxels() > summary.segmented_points() || summary.segments() > summary.supervoxels()) {
    return malformed(
        fmt::format("the numbers of the summary contradict each other: {} points, {} finite points, {} points of the "
                    "support plane, {} segmented points, {} supervoxels, {} segments",
                    points, summary.finite_points(), summary.support_plane().points(), summary.segmented_points(),
                    summary.supervoxels(), summary.segments()));
  }
  return absl::OkStatus();
}

/// A reason that this version does not know counts as "given".
Resolution read_resolution(const v1::Resolution& message) {
  Resolution resolution{message.voxel_resolution(), message.seed_resolution(), ResolutionReason::kGiven, std::nullopt};
  resolution.reason = resolution_reason(message.reason()).value_or(ResolutionReason::kGiven);
  if (message.has_noise_depth()) resolution.noise_depth = message.noise_depth();
  return resolution;
}

absl::StatusOr<Result> read_summary(const v1::ResultSummary& summary, std::size_t points) {
  RETURN_IF_ERROR(check_numbers(summary, points));
  std::vector<FieldViolation> faults;
  const std::optional<View> view = from_message(summary.view(), faults);
  if (!view || !faults.empty()) return malformed("the result does not say which view was used");
  if (const auto fault = fault_of_cameras(*view, points)) return malformed("the view of the result: " + *fault);
  const std::optional<Method> method = from_message(summary.method());
  if (!method) return malformed("the result does not say which method was used");

  Result result;
  result.segmentation.segments = summary.segments();
  result.segmentation.finite_points = summary.finite_points();
  result.segmentation.segmented_points = summary.segmented_points();
  if (summary.has_support_plane()) result.segmentation.support_plane = read_support_plane(summary.support_plane());
  result.segmentation.voxels = summary.voxels();
  if (summary.has_threshold()) result.segmentation.threshold = summary.threshold();
  result.segmentation.lambda = summary.lambda();
  result.segmentation.resolution = read_resolution(summary.resolution());
  read_timings(summary.timings(), result.timings, result.segmentation.timings);
  result.points = points;
  result.supervoxels = summary.supervoxels();
  result.method = *method;
  if (summary.has_regions()) result.regions = summary.regions();
  result.view = *view;
  result.view_rule = summary.view_rule();
  for (const v1::Warning& warning : summary.warnings()) {
    result.warnings.push_back({codec::warning_reason(warning.reason()), warning.message()});
  }
  if (summary.has_placement()) {
    const auto placement = read_placement(summary.placement());
    if (!placement) return malformed("the placement of the result is no scale and offset");
    result.placement = *placement;
  }
  result.server_version = summary.server_version();
  result.options_hash = summary.options_hash();
  return result;
}

}  // namespace

Result make_result(Segmentation segmentation, const CloudView& cloud, const Options& options, std::string view_rule,
                   std::string version) {
  Result result;
  result.points = cloud.size();
  result.supervoxels = static_cast<std::uint32_t>(segmentation.tree.leaf_count());
  result.method = options.method;
  result.regions = options.regions;
  result.view = segmented_view(cloud.view, options.preset);
  result.view_rule = result.view == cloud.view ? std::move(view_rule) : fmt::format("preset {}", name(options.preset));
  result.server_version = std::move(version);
  result.options_hash = options_hash(options);
  result.warnings = warnings_of(segmentation, result.view.kind);
  result.segmentation = std::move(segmentation);
  return result;
}

void take_payload_facts(const codec::Placement& placement, const std::vector<codec::Warning>& warnings,
                        Result& result) {
  result.warnings.insert(result.warnings.begin(), warnings.begin(), warnings.end());
  if (placement.is_identity()) return;
  result.placement = placement;
  result.view = codec::to_file(placement, result.view);
  codec::to_file(placement, result.segmentation);
  if (result.selection) codec::to_file(placement, *result.selection);
}

absl::StatusOr<v1::SegmentationResult> to_message(const Result& result, const Outputs& outputs) {
  v1::SegmentationResult message;
  fill_summary(result, *message.mutable_summary());
  const Segmentation& segmentation = result.segmentation;
  const v1::Compression compression = to_message(outputs.compression);
  if (outputs.labels) {
    ASSIGN_OR_RETURN(*message.mutable_labels(), to_message(segmentation.labels, compression));
  }
  if (outputs.supervoxels) {
    ASSIGN_OR_RETURN(*message.mutable_supervoxels(), to_message(segmentation.supervoxels, compression));
  }
  if (outputs.tree) {
    ASSIGN_OR_RETURN(*message.mutable_tree(), to_message(segmentation.tree, compression));
  }
  if (outputs.segments) *message.mutable_segments() = to_message(segmentation.statistics);
  if (result.selection) {
    *message.mutable_selection() = to_message(*result.selection);
    if (outputs.labels) {
      ASSIGN_OR_RETURN(*message.mutable_selected(), to_message(result.selection->labels, compression));
    }
  }
  if (result.tracks) *message.mutable_tracking() = to_message(*result.tracks);
  return message;
}

void set_final_timings(v1::SegmentationResult& message, double encode_ms, double total_ms) {
  message.mutable_summary()->mutable_timings()->set_encode_ms(encode_ms);
  message.mutable_summary()->mutable_timings()->set_total_ms(total_ms);
}

absl::StatusOr<Result> from_message(const v1::SegmentationResult& message, std::size_t points) {
  ASSIGN_OR_RETURN(Result result, read_summary(message.summary(), points));
  Segmentation& segmentation = result.segmentation;
  if (message.has_labels()) {
    ASSIGN_OR_RETURN(segmentation.labels, from_message(message.labels(), points, segmentation.segments, "labels"));
  }
  if (message.has_supervoxels()) {
    ASSIGN_OR_RETURN(segmentation.supervoxels,
                     from_message(message.supervoxels(), points, result.supervoxels, "supervoxels"));
  }
  if (message.segments_size() > 0) {
    ASSIGN_OR_RETURN(segmentation.statistics,
                     from_message(message.segments(), segmentation.segments, segmentation.segmented_points));
  }
  if (message.has_tree()) {
    ASSIGN_OR_RETURN(segmentation.tree,
                     from_message(message.tree(), result.supervoxels, segmentation.segmented_points));
  }
  if (message.has_selection()) {
    ASSIGN_OR_RETURN(result.selection, from_message(message.selection(), points, result.supervoxels));
    if (message.has_selected()) {
      ASSIGN_OR_RETURN(result.selection->labels, from_message(message.selected(), points, 1, "selected"));
    }
  }
  if (message.has_tracking()) {
    ASSIGN_OR_RETURN(result.tracks, from_message(message.tracking(), segmentation.segments));
  }
  return result;
}

}  // namespace segserve::wire
