// SPDX-License-Identifier: Apache-2.0
#include <cmath>
#include <cstddef>

#include "core/base/status_macros.hpp"
#include "core/base/status_text.hpp"
#include "core/base/strict_json.hpp"
#include "core/lab/eval/report.hpp"
#include "fmt/format.h"
#include "nlohmann/json.hpp"

namespace segserve::eval {
namespace {

using Json = nlohmann::ordered_json;

Json number_or_null(std::optional<double> value) { return value && std::isfinite(*value) ? Json(*value) : Json(); }

/// The metric "one_to_one.wov" is the member wov of the member one_to_one.
Json::json_pointer pointer_to(const Metric& metric) {
  std::string path = fmt::format("/{}", metric.name);
  for (char& c : path) c = c == '.' ? '/' : c;
  return Json::json_pointer(path);
}

void add_metrics(Json& json, const MetricValues& values) {
  for (std::size_t m = 0; m < kMetrics.size(); ++m) json[pointer_to(kMetrics[m])] = number_or_null(values[m]);
}

Json learned_json(const LearnedThreshold& learned) {
  const ThresholdSweep& sweep = learned.sweep;
  Json json = {{"data", learned.folder},
               {"scenes", sweep.scenes()},
               {"threshold", ThresholdSweep::threshold(sweep.best())},
               {"one_to_one_tp", sweep.tp(sweep.best())}};
  if (learned.with_curve) {
    Json& curve = json["curve"] = Json::array();
    for (std::size_t i = 0; i < ThresholdSweep::kThresholds; ++i) {
      curve.push_back({{"threshold", ThresholdSweep::threshold(i)}, {"one_to_one_tp", sweep.tp(i)}});
    }
  }
  return json;
}

/// JSON must be UTF-8, but file names need not be: other bytes are replaced.
std::string one_line(const Json& json) { return json.dump(-1, ' ', false, Json::error_handler_t::replace) + "\n"; }

absl::StatusOr<SceneScores> scene_from(const Json& json, std::size_t row) {
  if (!json.is_object() || !json.contains("file") || !json["file"].is_string()) {
    return absl::InvalidArgumentError(fmt::format("per_scene[{}] has no file", row));
  }
  SceneScores scene{json["file"].get<std::string>(), {}};
  for (std::size_t m = 0; m < kMetrics.size(); ++m) {
    const auto pointer = pointer_to(kMetrics[m]);
    if (!json.contains(pointer) || json[pointer].is_null()) continue;
    if (!json[pointer].is_number()) {
      return absl::InvalidArgumentError(fmt::format("per_scene[{}]: {} is not a number", row, kMetrics[m].name));
    }
    scene.values[m] = json[pointer].get<double>();
  }
  return scene;
}

Json json_of(const Report& report) {
  Json json;
  json["scenes"] = report.per_scene.size();
  json["method"] = report.method;
  json["threshold"] = number_or_null(report.threshold);
  json["data"] = report.folder;
  json["view"] = report.view.empty() ? Json() : Json(report.view);
  const Degradation& d = report.degradation;
  json["degradation"] = {
      {"scale", d.scale}, {"noise_mm", d.noise_mm}, {"keep", d.keep}, {"color", d.color}, {"seed", d.seed}};
  json["learnt"] = report.learned ? learned_json(*report.learned) : Json();
  add_metrics(json, mean(report.per_scene));
  Json& rows = json["per_scene"] = Json::array();
  for (const SceneScores& scene : report.per_scene) {
    Json row = {{"file", scene.file}};
    add_metrics(row, scene.values);
    rows.push_back(std::move(row));
  }
  Json& failed = json["failed"] = Json::array();
  for (const SceneFailure& scene : report.failed) {
    failed.push_back({{"file", scene.file}, {"error", message_of(scene.status)}});
  }
  return json;
}

Json json_of(const std::vector<PairedDifference>& differences) {
  Json metrics = Json::object();
  for (const PairedDifference& d : differences) {
    metrics[std::string(kMetrics[d.metric].name)] = {{"scenes", d.scenes},
                                                     {"mean_a", d.mean_a},
                                                     {"mean_b", d.mean_b},
                                                     {"difference", d.difference},
                                                     {"interval95", {d.low, d.high}},
                                                     {"t", number_or_null(d.t)},
                                                     {"p_two_sided", d.p_two_sided},
                                                     {"p_better", number_or_null(d.p_better)}};
  }
  return metrics;
}

}  // namespace

std::string to_json(const Report& report, const Peer* peer) {
  Json json = json_of(report);
  if (peer != nullptr) {
    json["peer"] = json_of(peer->report);
    json["differences"] = json_of(peer->differences);
  }
  return one_line(json);
}

absl::StatusOr<Report> report_from_json(std::string_view text) {
  const auto parsed = parse_strict_json<Json>(text);
  if (!parsed.ok()) {
    return absl::InvalidArgumentError(fmt::format("not a result of segctl eval: {}", message_of(parsed.status())));
  }
  const Json& json = *parsed;
  const bool looks_right = json.is_object() && json.contains("method") && json["method"].is_string() &&
                           json.contains("per_scene") && json["per_scene"].is_array();
  if (!looks_right) {
    return absl::InvalidArgumentError("not a result of segctl eval: no JSON object with method and per_scene");
  }
  Report report;
  report.method = json["method"].get<std::string>();
  for (const Json& row : json["per_scene"]) {
    ASSIGN_OR_RETURN(SceneScores scene, scene_from(row, report.per_scene.size()));
    report.per_scene.push_back(std::move(scene));
  }
  return report;
}

std::string to_json(const std::vector<PairedDifference>& differences, const std::string& a, const std::string& b) {
  return one_line({{"a", a}, {"b", b}, {"differences", json_of(differences)}});
}

}  // namespace segserve::eval
