// SPDX-License-Identifier: Apache-2.0
#include "client/segctl/bench_json.hpp"

#include <cmath>
#include <string>

#include "client/segctl/bench_host.hpp"
#include "client/segctl/server_metrics_json.hpp"
#include "nlohmann/json.hpp"

namespace segserve::segctl {
namespace {

using Json = nlohmann::ordered_json;

/// A figure that is computed from results: null if there is none, or if it is infinite.
Json figure(double value, std::uint64_t results) { return results > 0 && std::isfinite(value) ? Json(value) : Json(); }

Json finite(std::optional<double> value) { return value && std::isfinite(*value) ? Json(*value) : Json(); }

Json latency_json(const bench::Latencies& latencies) {
  Json json;
  for (const auto& [name, percent] : bench::kPercentiles) {
    json[name] = figure(latencies.percentile(percent), latencies.results());
  }
  json["max"] = figure(latencies.max(), latencies.results());
  json["mean"] = figure(latencies.mean(), latencies.results());
  return json;
}

/// The percentiles that are those of failed frames.
Json beyond_json(const bench::Latencies& latencies) {
  Json names = Json::array();
  for (const auto& [name, percent] : bench::kPercentiles) {
    if (std::isinf(latencies.percentile(percent))) names.push_back(name);
  }
  return names;
}

Json histogram_json(const bench::Latencies& latencies) {
  Json buckets = Json::array();
  const auto& counts = latencies.histogram().counts();
  for (std::size_t i = 0; i < counts.size(); ++i) {
    if (counts[i] > 0) buckets.push_back({bench::HdrHistogram::highest_of(i), counts[i]});
  }
  return {{"unit", "us"},
          {"significant_digits", bench::HdrHistogram::kSignificantDigits},
          {"failed", latencies.failed()},
          {"buckets", std::move(buckets)}};
}

Json stages_json(const bench::Report& report) {
  Json stages = Json::object();
  for (std::size_t i = 0; i < bench::kStages.size(); ++i) {
    stages[std::string(bench::kStages[i])] = figure(report.mean_stage_ms(i), report.results);
  }
  return stages;
}

Json per_frame(std::uint64_t bytes, const bench::Report& report) {
  return report.results == 0 ? Json() : Json(static_cast<double>(bytes) / static_cast<double>(report.results));
}

Json codec_json(const std::string& name, const bench::Report& report, Json cpu_ms_per_frame) {
  return {{"codec", name},
          {"sent", report.sent},
          {"results", report.results},
          {"failed", report.failed()},
          {"frames_per_s", report.frames_per_second()},
          {"mpoints_per_s", report.mpoints_per_second()},
          {"latency_ms", latency_json(report.latency)},
          {"bytes_up_per_frame", per_frame(report.bytes_up, report)},
          {"bytes_down_per_frame", per_frame(report.bytes_down, report)},
          {"stages_ms", stages_json(report)},
          {"client_cpu_ms_per_frame", std::move(cpu_ms_per_frame)}};
}

Json codecs_json(const BenchSummary& summary) {
  const bench::LoadResult& result = summary.result;
  Json list = Json::array();
  for (std::size_t i = 0; i < result.codecs.size(); ++i) {
    const bool is_alone = result.codecs.size() == 1;  // the CPU time of this process cannot be told apart by codec
    list.push_back(codec_json(summary.codecs[i], result.codecs[i],
                              is_alone ? figure(result.cpu_ms_per_frame(), result.total.finished) : Json()));
  }
  return list;
}

Json timeline_json(const std::vector<bench::TimelineEntry>& timeline) {
  Json list = Json::array();
  for (const bench::TimelineEntry& entry : timeline) {
    list.push_back({{"t", entry.t},
                    {"seconds", entry.seconds},
                    {"offered", entry.offered},
                    {"sent", entry.sent},
                    {"results", entry.results},
                    {"failed", entry.failed},
                    {"late", entry.late},
                    {"p50_ms", finite(entry.p50_ms)},
                    {"p90_ms", finite(entry.p90_ms)},
                    {"p99_ms", finite(entry.p99_ms)},
                    {"max_ms", finite(entry.max_ms)},
                    {"client_busy_cpus", entry.client_busy_cpus},
                    {"client_rss_bytes", entry.client_rss_bytes}});
  }
  return list;
}

Json point_json(const bench::LoadPoint& point) {
  const bench::Report& report = point.report;
  return {{"label", point.label},
          {"clients", point.clients},
          {"offered_frames_per_s", finite(point.offered)},
          {"achieved_frames_per_s", report.frames_per_second()},
          {"mpoints_per_s", report.mpoints_per_second()},
          {"bytes_up_per_s",
           report.results == 0 ? 0.0 : report.frames_per_second() * per_frame(report.bytes_up, report).get<double>()},
          {"latency_ms", latency_json(report.latency)},
          {"failed", report.failed()},
          {"least_share_percent", figure(report.least_share_percent(), report.finished)},
          {"server_cpu_ms_per_frame", finite(point.server_cpu_ms_per_frame)},
          {"verdict", point.verdict.empty() ? Json() : Json(point.verdict)}};
}

Json search_json(const BenchSummary& summary) {
  if (!summary.capacity) return nullptr;
  const bench::Capacity& capacity = *summary.capacity;
  Json tries = Json::array();
  for (const bench::SearchTry& each : capacity.tries) {
    tries.push_back({{"offered_frames_per_s", each.rate}, {"met", each.met}});
  }
  return {{"objective", summary.search->text},
          {"capacity_frames_per_s", capacity.low > 0 ? Json(capacity.low) : Json()},
          {"low", capacity.low},
          {"high", finite(capacity.high)},
          {"tries", std::move(tries)}};
}

Json objectives_json(const BenchSummary& summary) {
  Json list = Json::array();
  for (const bench::Objective& objective : summary.objectives) {
    const bench::Report& total = summary.result.total;
    list.push_back(
        {{"objective", objective.text}, {"value", finite(value(objective, total))}, {"met", is_met(objective, total)}});
  }
  return list;
}

template <typename Counts>
Json counts_json(const Counts& counts) {
  Json json = Json::object();
  for (const auto& [key, count] : counts) json[key] = count;
  return json;
}

/// Adds what was asked for, and under which conditions it was measured.
void add_conditions(const BenchSummary& summary, Json& json) {
  const bench::LoadOptions& load = summary.load;
  json["format"] = "segserve-bench-1";
  json["started"] = utc_time(summary.started);
  json["command"] = command_line_json();
  json["host"] = summary.host;
  json["client_build"] = client_build_json();
  json["server_info"] = summary.server_info;
  json["server"] = summary.server;
  json["clients"] = load.clients;
  json["in_flight"] = load.stream.max_in_flight;
  json["loop"] = load.is_open() ? "open" : "closed";
  json["arrivals"] = load.is_open() ? Json(arrivals_name(load)) : Json();
  json["speed"] = load.replay_speed > 0 ? Json(load.replay_speed) : Json();
  json["codec"] = summary.codec();
  json["encoded_beforehand"] = load.encoded_beforehand;
}

}  // namespace

Json to_json(const BenchSummary& summary) {
  const bench::LoadResult& result = summary.result;
  const bench::Report& total = result.total;
  Json json;
  add_conditions(summary, json);
  json["offered_frames_per_s"] = finite(summary.offered);
  json["achieved_frames_per_s"] = total.frames_per_second();
  json["window"] = {{"warm_up_s", result.warm_up_s}, {"measured_s", total.seconds}, {"drain_s", result.drain_s}};
  json["seconds"] = total.seconds;
  json["frames"] = {{"sent", total.sent},       {"results", total.results},   {"failed", total.failed()},
                    {"dropped", total.dropped}, {"finished", total.finished}, {"repeated", total.repeated},
                    {"hedged", total.hedged},   {"late", total.late}};
  json["results_of_server"] = counts_json(total.results_of_server);
  json["results_of_client"] = total.finished_of_client;
  json["least_share_percent"] = figure(total.least_share_percent(), total.finished);
  json["errors"] = counts_json(total.errors);
  json["frames_per_s"] = total.frames_per_second();
  json["mpoints_per_s"] = total.mpoints_per_second();
  json["latency_ms"] = latency_json(total.latency);
  json["latency_beyond"] = beyond_json(total.latency);
  json["too_few_samples_for"] = bench::too_few_for(total.latency);
  json["since_sent_ms"] = latency_json(total.since_sent);
  json["latency_histogram"] = histogram_json(total.latency);
  json["since_sent_histogram"] = histogram_json(total.since_sent);
  json["bytes_up"] = total.bytes_up;
  json["bytes_down"] = total.bytes_down;
  json["stages_ms"] = stages_json(total);
  json["client_cpu_ms_per_frame"] = figure(result.cpu_ms_per_frame(), total.finished);
  json["client_busy_cpus"] = result.busy_cpus();
  json["verified"] = summary.load.verify ? Json(total.verified) : Json();
  json["mismatches"] = summary.load.verify ? Json(total.mismatches) : Json();
  json["objectives"] = objectives_json(summary);
  json["codecs"] = codecs_json(summary);
  json["points"] = Json::array();
  for (const bench::LoadPoint& point : summary.points) json["points"].push_back(point_json(point));
  json["search"] = search_json(summary);
  json["server_metrics"] = summary.server_metrics ? server_metrics_json(*summary.server_metrics) : Json();
  json["faults"] = summary.faults ? counts_json(*summary.faults) : Json();
  json["findings"] = Json::array();
  for (const bench::Finding& finding : summary.findings) {
    json["findings"].push_back({{"code", finding.code}, {"text", finding.text}});
  }
  json["timeline"] = timeline_json(result.timeline);
  return json;
}

}  // namespace segserve::segctl
