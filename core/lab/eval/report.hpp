#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "absl/status/statusor.h"
#include "core/lab/eval/comparison.hpp"
#include "core/lab/eval/degrade.hpp"
#include "core/lab/eval/partition_metrics.hpp"
#include "core/lab/eval/threshold_sweep.hpp"

namespace segserve::eval {

/// A threshold and what it was learnt on.
struct Learnt {
  std::string folder;
  ThresholdSweep sweep;
  bool with_curve = false;  ///< the JSON lists the tp of every threshold
};

/// A method on the scenes of a folder.
struct Report {
  std::string method;
  std::optional<double> threshold;  ///< unset if cut at a number of regions, or if the method has none
  std::string folder;
  Degradation degradation;
  std::optional<Learnt> learnt;
  std::vector<SceneScores> per_scene;
};

/// One JSON object, one line: scenes, method, threshold, data, degradation, learnt, the means of all metrics, and
/// per_scene, the metrics of each scene after its `file`. A metric that is undefined is null.
std::string to_json(const Report& report);

/// Tables for people.
std::string to_text(const Report& report);

/// What `compare` needs of such an object: method and per_scene. INVALID_ARGUMENT if it is none.
absl::StatusOr<Report> report_from_json(std::string_view json);

/// `a` and `b` name the two; one JSON object, one line.
std::string to_json(const std::vector<PairedDifference>& differences, const std::string& a, const std::string& b);
std::string to_text(const std::vector<PairedDifference>& differences, const std::string& a, const std::string& b);

}  // namespace segserve::eval
