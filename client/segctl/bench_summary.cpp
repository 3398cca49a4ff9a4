// SPDX-License-Identifier: Apache-2.0
#include "client/segctl/bench_summary.hpp"

#include <algorithm>
#include <array>
#include <utility>

#include "fmt/format.h"
#include "nlohmann/json.hpp"

namespace segserve::segctl {
namespace {

using Json = nlohmann::ordered_json;

constexpr std::array<std::pair<const char*, double>, 4> kPercentiles{
    {{"p50", 50}, {"p90", 90}, {"p99", 99}, {"p99.9", 99.9}}};

/// A figure that is computed from results: null if there is none.
Json figure(double value, std::uint64_t results) { return results > 0 ? Json(value) : Json(); }

Json latency_json(const bench::Samples& samples) {
  Json json;
  for (const auto& [name, percent] : kPercentiles) json[name] = figure(samples.percentile(percent), samples.count());
  json["max"] = figure(samples.max(), samples.count());
  json["mean"] = figure(samples.mean(), samples.count());
  return json;
}

std::string latency_text(const bench::Samples& samples) {
  if (samples.count() == 0) return "no results";
  std::string text;
  for (const auto& [name, percent] : kPercentiles) {
    text += fmt::format("{} {:.1f}, ", name, samples.percentile(percent));
  }
  return text + fmt::format("max {:.1f}", samples.max());
}

/// The number of CPUs that this process kept busy.
double busy_cpus(const bench::Report& report) { return report.seconds > 0 ? report.cpu_seconds / report.seconds : 0; }

std::uint64_t per_result(std::uint64_t bytes, const bench::Report& report) {
  return report.results == 0 ? 0 : bytes / report.results;
}

/// When frames came in an open loop.
const char* arrivals_name(const bench::LoadOptions& load) {
  if (load.replay_speed > 0) return "recorded";
  return load.poisson ? "poisson" : "constant";
}

/// Describes the load and the server.
std::string load_text(const BenchSummary& summary) {
  const bench::LoadOptions& load = summary.load;
  const std::string loop = load.is_open()
                               ? fmt::format("{} arrivals at {:.4g} frames/s", arrivals_name(load), summary.offered)
                               : fmt::format("{} in flight each", load.stream.max_in_flight);
  return fmt::format("{} client{} at {}, {}, {}: {} frames in {:.1f} s\n", load.clients, load.clients == 1 ? "" : "s",
                     summary.server, loop, summary.codec, summary.report.sent, summary.report.seconds);
}

/// Where the time of a frame with a result goes.
std::string cost_text(const bench::Report& report) {
  std::string text = "stages ms     ";
  for (std::size_t i = 0; i < bench::kStages.size(); ++i) {
    text += fmt::format("{}{} {:.2f}", i == 0 ? "" : ", ", bench::kStages[i], report.mean_stage_ms(i));
  }
  return text + fmt::format("\nthis process  {:.2f} ms of CPU a frame, {:.2f} CPUs busy\n", report.cpu_ms_per_frame(),
                            busy_cpus(report));
}

}  // namespace

Json to_json(const BenchSummary& summary) {
  const bench::Report& report = summary.report;
  const bench::LoadOptions& load = summary.load;
  const bool open = load.is_open();
  Json json;
  json["server"] = summary.server;
  json["clients"] = load.clients;
  json["in_flight"] = load.stream.max_in_flight;
  json["loop"] = open ? "open" : "closed";
  json["arrivals"] = open ? Json(arrivals_name(load)) : Json();
  json["speed"] = load.replay_speed > 0 ? Json(load.replay_speed) : Json();
  json["offered_frames_per_s"] = open ? Json(summary.offered) : Json();
  json["codec"] = summary.codec;
  json["encoded_beforehand"] = load.encoded_beforehand;
  json["seconds"] = report.seconds;
  json["frames"] = {
      {"sent", report.sent}, {"results", report.results}, {"repeated", report.repeated}, {"late", report.late}};
  json["results_of_client"] = report.results_of_client;
  json["least_share_percent"] = figure(report.least_share_percent(), report.results);
  json["errors"] = Json::object();
  for (const auto& [key, count] : report.errors) json["errors"][key] = count;
  json["frames_per_s"] = report.frames_per_second();
  json["mpoints_per_s"] = report.mpoints_per_second();
  json["latency_ms"] = latency_json(report.latency);
  json["since_sent_ms"] = latency_json(report.since_sent);
  json["bytes_up"] = report.bytes_up;
  json["bytes_down"] = report.bytes_down;
  json["stages_ms"] = Json::object();
  for (std::size_t i = 0; i < bench::kStages.size(); ++i) {
    json["stages_ms"][std::string(bench::kStages[i])] = figure(report.mean_stage_ms(i), report.results);
  }
  json["client_cpu_ms_per_frame"] = figure(report.cpu_ms_per_frame(), report.results);
  json["client_busy_cpus"] = busy_cpus(report);
  json["verified"] = load.verify ? Json(report.verified) : Json();
  json["mismatches"] = load.verify ? Json(report.mismatches) : Json();
  json["objectives"] = Json::array();
  for (const bench::Objective& objective : summary.objectives) {
    json["objectives"].push_back(
        {{"objective", objective.text}, {"value", value(objective, report)}, {"met", is_met(objective, report)}});
  }
  return json;
}

std::string to_text(const BenchSummary& summary) {
  const bench::Report& report = summary.report;
  const bench::LoadOptions& load = summary.load;
  std::string text = load_text(summary);
  text += fmt::format("throughput    {:.1f} frames/s, {:.2f} Mpoints/s; a frame {} bytes up, {} down\n",
                      report.frames_per_second(), report.mpoints_per_second(), per_result(report.bytes_up, report),
                      per_result(report.bytes_down, report));
  text += fmt::format("latency ms    {}\n", latency_text(report.latency));
  if (load.is_open()) {
    text += fmt::format("since sent    {}; {} frames sent late\n", latency_text(report.since_sent), report.late);
  }
  if (report.results > 0) text += cost_text(report);
  if (load.clients > 1) {
    text += fmt::format("fairness      the client with the fewest results got {:.0f} % of the mean\n",
                        report.least_share_percent());
  }
  for (const auto& [key, count] : report.errors) text += fmt::format("error         {} times {}\n", count, key);
  if (report.repeated > 0) text += fmt::format("repeated      {} frames were sent more than once\n", report.repeated);
  if (load.verify) {
    text += fmt::format("verified      {} label arrays, {} differ\n", report.verified, report.mismatches);
  }
  for (const bench::Objective& objective : summary.objectives) {
    text += fmt::format("objective     {}: {} ({:.3f})\n", objective.text, is_met(objective, report) ? "met" : "MISSED",
                        value(objective, report));
  }
  return text;
}

}  // namespace segserve::segctl
