// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "absl/status/statusor.h"
#include "core/lab/eval/comparison.hpp"
#include "core/lab/eval/degrade.hpp"
#include "core/lab/eval/evaluation.hpp"
#include "core/lab/eval/partition_metrics.hpp"
#include "core/lab/eval/threshold_sweep.hpp"

namespace segserve::eval {

/// A learned threshold, and the scenes it was learned on.
struct LearnedThreshold {
  std::string folder;
  ThresholdSweep sweep;
  bool with_curve = false;  ///< Whether the JSON lists the tp of every threshold.
};

/// The scores of a method on the scenes of a folder.
struct Report {
  std::string method;
  std::optional<double>
      threshold;  ///< Unset if the tree was cut at a number of regions, or if the method has no threshold.
  std::string folder;
  std::string view = {};  ///< The view that was given for all scenes, as text; empty if the files tell it.
  Degradation degradation;
  std::optional<LearnedThreshold> learned;
  std::vector<SceneScores> per_scene;
  std::vector<SceneFailure> failed = {};
};

/// The scores of a second method on the same scenes.
struct Peer {
  Report report;
  /// The differences that `compare` finds, with the peer as B, on the scenes that both could segment. Empty if these
  /// are fewer than two.
  std::vector<PairedDifference> differences;
};

/// Compares a report with that of a peer.
Peer compare_with(const Report& report, Report peer);

/// One line: the method, the scenes, and how they were scored.
std::string headline(const Report& report);

/// One JSON object in one line: scenes, method, threshold, data, view, degradation, learned, the means of all metrics,
/// per_scene with the file and the metrics of each scene, and failed with the file and the error of each scene that
/// could not be scored. A metric that is undefined is null. If there is a peer, the member peer is such an object, too,
/// and differences has what the JSON of a comparison has.
std::string to_json(const Report& report, const Peer* peer = nullptr);

/// Tables for people.
std::string to_text(const Report& report, const Peer* peer = nullptr);

/// Reads from such an object what `compare` needs: method and per_scene. INVALID_ARGUMENT if the text is not such an
/// object.
absl::StatusOr<Report> report_from_json(std::string_view json);

/// One JSON object in one line. `a` and `b` are the names of the two results.
std::string to_json(const std::vector<PairedDifference>& differences, const std::string& a, const std::string& b);
std::string to_text(const std::vector<PairedDifference>& differences, const std::string& a, const std::string& b);

}  // namespace segserve::eval
