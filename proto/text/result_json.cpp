// SPDX-License-Identifier: Apache-2.0
#include "proto/text/result_json.hpp"

#include <algorithm>
#include <cstdint>
#include <utility>

#include "nlohmann/json.hpp"
#include "proto/text/prompt_text.hpp"
#include "proto/text/view_text.hpp"

namespace segserve::text {
namespace {

using Json = nlohmann::ordered_json;

template <typename Value>
Json optional_json(const std::optional<Value>& value) {
  return value ? Json(*value) : Json();
}

Json optional_vector_json(const std::optional<Eigen::Vector3d>& v) { return v ? vector_json(*v) : Json(); }

Json text_or_null(const std::string& text) { return text.empty() ? Json() : Json(text); }

/// The number of points of each segment: entry s - 1 is that of segment s.
std::vector<std::size_t> segment_sizes(const Segmentation& segmentation) {
  std::vector<std::size_t> sizes(segmentation.segments);
  for (const std::uint32_t label : segmentation.labels) {
    if (label > 0) ++sizes[label - 1];
  }
  return sizes;
}

Json segments_json(const Segmentation& segmentation) {
  Json json = Json::array();
  for (const SegmentStatistics& segment : segmentation.statistics)
    json.push_back(segment_json(json.size() + 1, segment));
  return json;
}

Json support_plane_json(const std::optional<SupportPlane>& plane) {
  if (!plane) return {};
  return {{"points", plane->points}, {"normal", vector_json(plane->normal)}, {"offset", plane->offset}};
}

Json places_json(const std::vector<PromptedPoint>& points, const std::vector<Prompt>& prompts) {
  Json json = Json::array();
  for (std::size_t k = 0; k < std::min(points.size(), prompts.size()); ++k) {
    json.push_back({{"place", prompt_text(prompts[k])},
                    {"point", points[k].point},
                    {"distance", points[k].distance},
                    {"supervoxel", points[k].supervoxel}});
  }
  return json;
}

/// The id of each segment, and what became of the objects.
void add_tracks(const wire::Tracks& tracks, Json& json) {
  json["track_ids"] = tracks.track_of_segment;
  Json& events = json["track_events"] = Json::array();
  for (const TrackEvent& event : tracks.events) {
    Json item{{"kind", name(event.kind)}, {"track", event.track}};
    if (event.other != 0) item["other"] = event.other;
    events.push_back(std::move(item));
  }
  json["track_state_bytes"] = tracks.state.size();
}

}  // namespace

std::vector<Timing> stage_timings(const wire::Result& result) {
  const StageTimings& stages = result.segmentation.timings;
  const wire::CallTimings& call = result.timings;
  std::vector<Timing> timings{{"queue", call.queue},
                              {"decode", call.decode},
                              {"voxels", stages.voxels},
                              {"normals", stages.normals},
                              {"supervoxels", stages.supervoxels},
                              {"graph", stages.graph},
                              {"merging", stages.merging},
                              {"labels", stages.labels}};
  if (result.tracks) timings.push_back({"tracking", stages.tracking});
  for (const Timing& timing :
       {Timing{"segments", stages.segments}, Timing{"encode", call.encode}, Timing{"total", call.total}}) {
    timings.push_back(timing);
  }
  return timings;
}

Json vector_json(const Eigen::Vector3d& v) { return {v.x(), v.y(), v.z()}; }

Json warnings_json(const std::vector<codec::Warning>& warnings) {
  Json json = Json::array();
  for (const codec::Warning& warning : warnings) {
    json.push_back({{"reason", name(warning.reason)}, {"message", warning.message}});
  }
  return json;
}

Json segment_json(std::size_t label, const SegmentStatistics& segment) {
  Json axes = Json::array();
  for (int k = 0; k < 3; ++k) axes.push_back(vector_json(segment.box.axes.col(k)));
  const auto& thresholds = segment.thresholds;
  return {{"label", label},
          {"points", segment.points},
          {"centroid", vector_json(segment.centroid)},
          {"box",
           {{"center", vector_json(segment.box.center)},
            {"axes", axes},
            {"half_extents", vector_json(segment.box.half_extents)}}},
          {"color", optional_vector_json(segment.color)},
          {"normal", optional_vector_json(segment.normal)},
          {"thresholds", thresholds ? Json{thresholds->from, thresholds->to} : Json()},
          {"stability", thresholds ? Json(thresholds->stability()) : Json()}};
}

Json candidate_json(const MergeTree& tree, const std::vector<std::uint32_t>& nodes, const ThresholdRange& thresholds) {
  std::uint64_t points = 0;
  for (const std::uint32_t node : nodes) {
    points += node < tree.leaf_count() ? tree.leaf_points[node] : tree.points[node - tree.leaf_count()];
  }
  return {{"nodes", nodes},
          {"points", points},
          {"thresholds", {thresholds.from, thresholds.to}},
          {"stability", thresholds.stability()}};
}

Json selection_json(const PromptedSelection& selected, const Prompts& prompts, const MergeTree& tree) {
  Json json{{"include", places_json(selected.include, prompts.include)},
            {"exclude", places_json(selected.exclude, prompts.exclude)},
            {"candidate", selected.candidate},
            {"candidate_count", selected.selection.candidates()}};
  json["picked"] = tree.leaf_count() == 0
                       ? Json()
                       : candidate_json(tree, nodes_of(selected.selection, selected.candidate), selected.thresholds);
  json["segment"] = selected.statistics ? segment_json(1, *selected.statistics) : Json();
  return json;
}

Json to_json(const wire::Result& result, const JsonContent& content) {
  const Segmentation& segmentation = result.segmentation;
  const Resolution& resolution = segmentation.resolution;
  Json json;
  json["points"] = result.points;
  json["finite"] = segmentation.finite_points;
  json["segmented"] = segmentation.segmented_points;
  json["support_plane"] = support_plane_json(segmentation.support_plane);
  json["voxels"] = segmentation.voxels;
  json["resolution"] = {{"voxel", resolution.voxel},
                        {"seed", resolution.seed},
                        {"reason", name(resolution.reason)},
                        {"noise_depth", optional_json(resolution.noise_depth)}};
  json["supervoxels"] = result.supervoxels;
  json["segments"] = segmentation.segments;
  json["segment_points"] = segment_sizes(segmentation);
  if (content.with_segments) json["segment_statistics"] = segments_json(segmentation);
  if (result.selection && content.prompts) {
    json["selection"] = selection_json(*result.selection, *content.prompts, segmentation.tree);
  }
  if (result.tracks) add_tracks(*result.tracks, json);
  json["method"] = name(result.method);
  json["threshold"] = optional_json(segmentation.threshold);
  json["regions"] = optional_json(result.regions);
  json["lambda"] = segmentation.lambda;
  json["view"] = view_text(result.view);
  json["view_rule"] = result.view_rule;
  json["placement"] = {{"scale", vector_json(result.placement.scale)},
                       {"offset", vector_json(result.placement.offset)}};
  json["warnings"] = warnings_json(result.warnings);
  json["options_hash"] = result.options_hash;
  json["server"] = text_or_null(content.server);
  json["version"] = result.server_version;
  Json& timings = json["timings_ms"] = Json::object();
  for (const Timing& timing : content.timings) timings[timing.name] = timing.ms;
  return json;
}

}  // namespace segserve::text
