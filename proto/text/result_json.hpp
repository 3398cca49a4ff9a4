// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "nlohmann/json_fwd.hpp"
#include "segserve/codec/warning.hpp"
#include "segserve/prompts.hpp"
#include "segserve/segment_statistics.hpp"
#include "segserve/wire/result.hpp"

// A result as JSON: what `segctl segment --json` writes, and what the web entrance of a server answers.
namespace segserve::text {

/// A named time in milliseconds.
struct Timing {
  std::string name;
  double ms = 0;
};

/// The times that the server, or the local run, measured. The last one is the total.
std::vector<Timing> stage_timings(const wire::Result& result);

/// An array of three numbers.
nlohmann::ordered_json vector_json(const Eigen::Vector3d& v);

/// An array of objects with `reason` and `message`.
nlohmann::ordered_json warnings_json(const std::vector<codec::Warning>& warnings);

/// A segment as an object with label, points, centroid, box, color, normal, thresholds and stability. The last four may
/// be null.
nlohmann::ordered_json segment_json(std::size_t label, const SegmentStatistics& segment);

/// A candidate of a selection: nodes, points, thresholds and stability. `nodes` are its nodes.
nlohmann::ordered_json candidate_json(const MergeTree& tree, const std::vector<std::uint32_t>& nodes,
                                      const ThresholdRange& thresholds);

/// Writes the selection by prompts: include and exclude (each with place, point, distance and supervoxel), candidate,
/// candidate_count, picked, and segment, which is null without statistics. `picked` is null without the tree.
nlohmann::ordered_json selection_json(const PromptedSelection& selected, const Prompts& prompts, const MergeTree& tree);

/// The facts that to_json tells beside the result itself.
struct JsonContent {
  std::string server = {};                        ///< its address; empty if no server took part
  std::vector<Timing> timings = {};               ///< in the order in which they are told
  bool with_segments = false;                     ///< whether the statistics of the segments are told
  std::optional<Prompts> prompts = std::nullopt;  ///< of the request, if the result has a selection
};

/// An object with at least points, finite, segmented, support_plane, supervoxels, segments, method, threshold, warnings
/// and timings_ms. support_plane is null unless its removal was asked for, and has 0 points if none was found;
/// threshold is null after a cut at a number of regions. If asked for, segment_statistics is an array of objects,
/// largest segment first. segment_points needs the labels, and selection is there if the result has one.
nlohmann::ordered_json to_json(const wire::Result& result, const JsonContent& content);

}  // namespace segserve::text
