// SPDX-License-Identifier: Apache-2.0
#include "client/segctl/summary.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>

#include "client/segctl/messages.hpp"
#include "fmt/format.h"
#include "nlohmann/json.hpp"
#include "proto/wire/result_message.hpp"

namespace segserve::segctl {
namespace {

using Json = nlohmann::ordered_json;

/// The number of points of each segment: entry s - 1 is that of segment s.
std::vector<std::size_t> segment_sizes(const Segmentation& segmentation) {
  std::vector<std::size_t> sizes(segmentation.segments);
  for (const std::uint32_t label : segmentation.labels) {
    if (label > 0) ++sizes[label - 1];
  }
  return sizes;
}

std::string support_plane_text(const SupportPlane& plane) {
  if (plane.points == 0) return "no support plane found\n";
  const auto rounded = [](double value) { return std::round(1e4 * value) / 1e4 + 0.0; };  // no negative zero
  const auto term = [&](double factor) {
    return fmt::format("{} {:.4f}", rounded(factor) < 0 ? "-" : "+", std::abs(rounded(factor)));
  };
  return fmt::format("support plane removed: {} points, {:.4f} x {} y {} z = {:.4f} m\n", plane.points,
                     rounded(plane.normal.x()), term(plane.normal.y()), term(plane.normal.z()), plane.offset);
}

std::string placement_text(const codec::Placement& placement) {
  std::string text;
  if (placement.meters_per_unit() != 1)
    text += fmt::format("a unit of the file is {:g} m\n", placement.meters_per_unit());
  if (placement.offset != Eigen::Vector3d::Zero()) {
    text += fmt::format("moved by ({}, {}, {}) while it was segmented; results are in the file's coordinates\n",
                        -placement.offset.x(), -placement.offset.y(), -placement.offset.z());
  }
  return text;
}

std::string cut_text(const client::Result& result) {
  if (result.regions) return fmt::format("cut at {} regions", *result.regions);
  return fmt::format("threshold {}", result.segmentation.threshold.value_or(0));
}

std::string sizes_text(const Segmentation& segmentation) {
  constexpr std::size_t kShown = 5;
  const std::vector<std::size_t> sizes = segment_sizes(segmentation);
  std::string text;
  for (std::size_t i = 0; i < std::min(kShown, sizes.size()); ++i) {
    text += fmt::format("{}{}", i == 0 ? "" : ", ", sizes[i]);
  }
  if (sizes.empty()) return "no segments";
  return fmt::format("{} points{}", text, sizes.size() > kShown ? ", ..." : "");
}

std::string timings_text(const Summary& summary) {
  std::string text;
  for (const Timing& timing : summary.timings) {
    text += fmt::format("{}{} {:.1f}", text.empty() ? "" : ", ", timing.name, timing.ms);
  }
  return fmt::format("ms {}: {}", summary.server.empty() ? "in this process" : "at " + summary.server, text);
}

}  // namespace

void take_file_facts(const codec::LabeledCloud& file, client::Result& result) {
  if (result.view == file.cloud.view) result.view_rule = file.view_rule;  // else a preset replaced the view
  wire::take_payload_facts(file.placement, file.warnings, result);
}

std::string resolution_text(const Resolution& resolution) {
  std::string voxels = fmt::format("voxels of {:.3g} mm", 1000 * resolution.voxel);
  switch (resolution.reason) {
    case ResolutionReason::kGiven:
      return voxels;
    case ResolutionReason::kDense:
      return voxels + " (auto)";
    case ResolutionReason::kSpacing:
      return voxels + " (auto, by the spacing of the points)";
    case ResolutionReason::kNoise:
      return voxels + " (auto, by the noise of the points)";
    case ResolutionReason::kExtent:
      return voxels + " (auto, by the size of the scene)";
    case ResolutionReason::kSweep:
      return voxels + " at 1 m (auto, as fine as the rays of the LiDAR)";
  }
  return voxels;
}

Json to_json(const Summary& summary) {
  return text::to_json(summary.result, {.server = summary.server,
                                        .timings = summary.timings,
                                        .with_segments = summary.with_segments,
                                        .prompts = summary.prompts});
}

std::string selection_text(const PromptedSelection& picked) {
  std::string text;
  if (picked.statistics) {
    const SegmentStatistics& segment = *picked.statistics;
    const Eigen::Vector3d size = 2 * segment.box.half_extents;
    const std::size_t nodes = picked.selection.smallest.size();
    text = fmt::format("picked {} points in {} node{}, {:.3g} x {:.3g} x {:.3g} at ({:.3f}, {:.3f}, {:.3f})\n",
                       segment.points, nodes, nodes == 1 ? "" : "s", size.x(), size.y(), size.z(), segment.centroid.x(),
                       segment.centroid.y(), segment.centroid.z());
  }
  return text + fmt::format("choice {} of {}, stable from threshold {:.3g} to {:.3g}\n", picked.candidate + 1,
                            picked.selection.candidates(), picked.thresholds.from, picked.thresholds.to);
}

std::string to_text(const Summary& summary) {
  const client::Result& result = summary.result;
  const Segmentation& segmentation = result.segmentation;
  const bool some_left_out = segmentation.segmented_points != segmentation.finite_points;
  std::string text =
      fmt::format("{}: {} points, {} finite{}; {}\n", summary.input, result.points, segmentation.finite_points,
                  some_left_out ? fmt::format(", {} segmented", segmentation.segmented_points) : "", result.view_rule);
  text += placement_text(result.placement);
  if (segmentation.support_plane) text += support_plane_text(*segmentation.support_plane);
  text += fmt::format("{}, {}, {}: {} supervoxels, {} segment{} ({})\n", name(result.method), cut_text(result),
                      resolution_text(segmentation.resolution), result.supervoxels, segmentation.segments,
                      segmentation.segments == 1 ? "" : "s", sizes_text(segmentation));
  if (result.selection) text += selection_text(*result.selection);
  return text + timings_text(summary) + "\n";
}

absl::Status report(Told told, const JsonFlag& json, bool quiet, StagedOutput& output) {
  told.json["warnings"] = warnings_json(told.warnings);
  json.add(output, told.json);
  if (!quiet && !output.uses_stdout()) {
    for (const codec::Warning& warning : told.warnings) told.text += fmt::format("warning: {}\n", warning.message);
    output.add("-", std::move(told.text));
  } else if (!json.given()) {
    for (const codec::Warning& warning : told.warnings) print_warning(warning.message);
  }
  return output.commit();
}

absl::Status report(const Summary& summary, const JsonFlag& json, bool quiet, StagedOutput& output) {
  return report(Told{to_json(summary), to_text(summary), summary.result.warnings}, json, quiet, output);
}

}  // namespace segserve::segctl
