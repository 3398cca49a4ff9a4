// SPDX-License-Identifier: Apache-2.0
#include "client/segctl/summary.hpp"

#include <algorithm>
#include <cstdint>

#include "client/segctl/messages.hpp"
#include "client/segctl/view_flag.hpp"
#include "fmt/format.h"
#include "nlohmann/json.hpp"
#include "proto/wire/result_message.hpp"

namespace segserve::segctl {
namespace {

using Json = nlohmann::ordered_json;

template <typename Value>
Json optional_json(const std::optional<Value>& value) {
  return value ? Json(*value) : Json();
}

Json text_or_null(const std::string& text) { return text.empty() ? Json() : Json(text); }

/// The number of points of each segment: entry s - 1 is that of segment s.
std::vector<std::size_t> segment_sizes(const Segmentation& segmentation) {
  std::vector<std::size_t> sizes(segmentation.segments);
  for (const std::uint32_t label : segmentation.labels) {
    if (label > 0) ++sizes[label - 1];
  }
  return sizes;
}

Json vector_json(const Eigen::Vector3d& v) { return {v.x(), v.y(), v.z()}; }

Json support_plane_json(const std::optional<SupportPlane>& plane) {
  if (!plane) return {};
  return {{"points", plane->points}, {"normal", vector_json(plane->normal)}, {"offset", plane->offset}};
}

Json optional_vector_json(const std::optional<Eigen::Vector3d>& v) { return v ? vector_json(*v) : Json(); }

Json segment_json(std::size_t label, const SegmentStatistics& segment) {
  Json axes = Json::array();
  for (int k = 0; k < 3; ++k) axes.push_back(vector_json(segment.box.axes.col(k)));
  return {{"label", label},
          {"points", segment.points},
          {"centroid", vector_json(segment.centroid)},
          {"box",
           {{"center", vector_json(segment.box.center)},
            {"axes", axes},
            {"half_extents", vector_json(segment.box.half_extents)}}},
          {"color", optional_vector_json(segment.color)},
          {"normal", optional_vector_json(segment.normal)}};
}

std::string support_plane_text(const SupportPlane& plane) {
  if (plane.points == 0) return "no support plane found\n";
  return fmt::format("support plane removed: {} points, {:.4f} x + {:.4f} y + {:.4f} z = {:.4f} m\n", plane.points,
                     plane.normal.x(), plane.normal.y(), plane.normal.z(), plane.offset);
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
  result.view_rule = file.view_rule;
  wire::take_payload_facts(file.placement, file.warnings, result);
}

Json warnings_json(const std::vector<codec::Warning>& warnings) {
  Json json = Json::array();
  for (const codec::Warning& warning : warnings) {
    json.push_back({{"reason", name(warning.reason)}, {"message", warning.message}});
  }
  return json;
}

std::vector<Timing> stage_timings(const client::Result& result) {
  const client::Result& r = result;
  const StageTimings& stages = r.segmentation.timings;
  return {{"queue", r.timings.queue},   {"decode", r.timings.decode},        {"voxels", stages.voxels},
          {"normals", stages.normals},  {"supervoxels", stages.supervoxels}, {"graph", stages.graph},
          {"merging", stages.merging},  {"labels", stages.labels},           {"segments", stages.segments},
          {"encode", r.timings.encode}, {"total", r.timings.total}};
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
  }
  return voxels;
}

Json to_json(const Summary& summary) {
  const client::Result& result = summary.result;
  Json json;
  json["points"] = result.points;
  json["finite"] = result.segmentation.finite_points;
  json["segmented"] = result.segmentation.segmented_points;
  json["support_plane"] = support_plane_json(result.segmentation.support_plane);
  json["voxels"] = result.segmentation.voxels;
  const Resolution& resolution = result.segmentation.resolution;
  json["resolution"] = {{"voxel", resolution.voxel},
                        {"seed", resolution.seed},
                        {"reason", name(resolution.reason)},
                        {"noise_depth", resolution.noise_depth ? Json(*resolution.noise_depth) : Json()}};
  json["supervoxels"] = result.supervoxels;
  json["segments"] = result.segmentation.segments;
  json["segment_points"] = segment_sizes(result.segmentation);
  if (summary.with_segments) {
    Json& statistics = json["segment_statistics"] = Json::array();
    for (const SegmentStatistics& segment : result.segmentation.statistics) {
      statistics.push_back(segment_json(statistics.size() + 1, segment));
    }
  }
  json["method"] = name(result.method);
  json["threshold"] = optional_json(result.segmentation.threshold);
  json["regions"] = optional_json(result.regions);
  json["lambda"] = result.segmentation.lambda;
  json["view"] = view_text(result.view);
  json["view_rule"] = result.view_rule;
  json["placement"] = {{"scale", vector_json(result.placement.scale)},
                       {"offset", vector_json(result.placement.offset)}};
  json["warnings"] = warnings_json(result.warnings);
  json["options_hash"] = result.options_hash;
  json["server"] = text_or_null(summary.server);
  json["version"] = result.server_version;
  Json& timings = json["timings_ms"] = Json::object();
  for (const Timing& timing : summary.timings) timings[timing.name] = timing.ms;
  return json;
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
  text += timings_text(summary) + "\n";
  for (const codec::Warning& warning : result.warnings) text += fmt::format("warning: {}\n", warning.message);
  return text;
}

absl::Status report(const Summary& summary, const JsonFlag& json, bool quiet, StagedOutput& output) {
  json.add(output, to_json(summary));
  if (!quiet && !output.uses_stdout()) {
    output.add("-", to_text(summary));
  } else if (!json.given()) {
    for (const codec::Warning& warning : summary.result.warnings) print_warning(warning.message);
  }
  return output.commit();
}

}  // namespace segserve::segctl
