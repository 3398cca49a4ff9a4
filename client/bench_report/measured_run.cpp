// SPDX-License-Identifier: Apache-2.0
#include "client/bench_report/measured_run.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "nlohmann/json.hpp"

namespace segserve::bench_report {
namespace {

using Json = nlohmann::ordered_json;

std::optional<double> number(const Json& object, const char* name) {
  const auto found = object.find(name);
  return found != object.end() && found->is_number() ? std::optional(found->get<double>()) : std::nullopt;
}

/// A member of the object, or null.
Json member(const Json& object, const char* name) {
  const auto found = object.find(name);
  return found == object.end() ? Json() : *found;
}

void read_histogram(const Json& histogram, MeasuredRun& run) {
  if (histogram.is_null()) return;
  for (const Json& bucket : histogram["buckets"]) {
    run.latency.push_back({.ms = bucket[0].get<double>() / 1000, .count = bucket[1].get<double>()});
  }
  run.failed = number(histogram, "failed").value_or(0);
}

void read_timeline(const Json& timeline, double measured_s, MeasuredRun& run) {
  if (timeline.size() > 1) {
    // The first entry may begin late, with the warm-up.
    run.step_s = timeline.back()["t"].get<double>() - timeline[timeline.size() - 2]["t"].get<double>();
  }
  for (const Json& entry : timeline) {
    const double t = entry["t"].get<double>();
    // Times in the file are rounded.
    const bool is_measured = t > -1e-3 * run.step_s && t + run.step_s <= measured_s + 1e-3 * run.step_s;
    if (!is_measured || number(entry, "seconds").value_or(run.step_s) < 0.99 * run.step_s) continue;
    run.timeline.push_back({.results = entry["results"].get<double>(),
                            .failed = number(entry, "failed").value_or(0),
                            .p50 = number(entry, "p50_ms"),
                            .p90 = number(entry, "p90_ms"),
                            .p99 = number(entry, "p99_ms"),
                            .max = number(entry, "max_ms"),
                            .busy_cpus = number(entry, "client_busy_cpus")});
  }
}

}  // namespace

double MeasuredRun::frames() const {
  double all = failed;
  for (const Bucket& bucket : latency) all += bucket.count;
  return all;
}

double MeasuredRun::quantile(double q) const {
  const double rank = std::max(1.0, std::ceil(q * frames() - 1e-9));
  double below = 0;
  for (const Bucket& bucket : latency) {
    below += bucket.count;
    if (below >= rank) return bucket.ms;
  }
  return std::numeric_limits<double>::infinity();
}

MeasuredRun measured_run(const Json& json) {
  MeasuredRun run;
  read_histogram(member(json, "latency_histogram"), run);
  const auto window = number(member(json, "window"), "measured_s");
  const double measured_s =
      window ? *window : number(json, "seconds").value_or(std::numeric_limits<double>::infinity());
  read_timeline(member(json, "timeline"), measured_s, run);
  run.sent = json["frames"]["sent"].get<double>();
  run.results = json["frames"]["results"].get<double>();
  run.dropped = number(json["frames"], "dropped").value_or(0);
  run.frames_per_s = number(json, "achieved_frames_per_s");
  run.client_cpu_ms = number(json, "client_cpu_ms_per_frame");
  run.server_cpu_ms = number(member(json, "server_metrics"), "cpu_ms_per_frame");
  return run;
}

}  // namespace segserve::bench_report
