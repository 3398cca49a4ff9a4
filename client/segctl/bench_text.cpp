// SPDX-License-Identifier: Apache-2.0
#include "client/segctl/bench_text.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>

#include "fmt/format.h"
#include "fmt/ranges.h"

namespace segserve::segctl {
namespace {

/// "12.3", or "never" for failed frames.
std::string latency_figure(double milliseconds) {
  return std::isinf(milliseconds) ? "never" : fmt::format("{:.1f}", milliseconds);
}

/// Percentiles for which there are too few frames stand in parentheses.
std::string latency_text(const bench::Latencies& latencies) {
  if (latencies.results() == 0) return "no results";
  std::string text;
  for (const auto& [name, percent] : bench::kPercentiles) {
    const bool bears = latencies.bears(percent);
    text += fmt::format("{}{} {}{}, ", bears ? "" : "(", name, latency_figure(latencies.percentile(percent)),
                        bears ? "" : ")");
  }
  return text + fmt::format("max {:.1f}", latencies.max());
}

std::uint64_t per_result(std::uint64_t bytes, const bench::Report& report) {
  return report.results == 0 ? 0 : bytes / report.results;
}

/// Describes the load and the server.
std::string load_text(const BenchSummary& summary) {
  const bench::LoadOptions& load = summary.load;
  const bench::Report& total = summary.result.total;
  const std::string loop =
      load.is_open() ? fmt::format("{} arrivals at {:.4g} frames/s", arrivals_name(load), summary.offered.value_or(0))
                     : fmt::format("{} in flight each", load.stream.max_in_flight);
  return fmt::format("{} client{} at {}, {}, {}: {} frames in {:.1f} s\n", load.clients, load.clients == 1 ? "" : "s",
                     summary.server, loop, summary.codec(), total.sent, total.seconds);
}

std::string throughput_text(const bench::Report& report) {
  return fmt::format("{:.1f} frames/s, {:.2f} Mpoints/s; a frame {} bytes up, {} down", report.frames_per_second(),
                     report.mpoints_per_second(), per_result(report.bytes_up, report),
                     per_result(report.bytes_down, report));
}

/// A line for each codec, if there are several.
std::string codecs_text(const BenchSummary& summary) {
  if (summary.result.codecs.size() < 2) return "";
  std::string text;
  for (std::size_t i = 0; i < summary.result.codecs.size(); ++i) {
    const bench::Report& report = summary.result.codecs[i];
    text += fmt::format("  {:<14}{}; latency ms {}{}\n", summary.codecs[i], throughput_text(report),
                        latency_text(report.latency),
                        report.failed() > 0 ? fmt::format("; {} failed", report.failed()) : "");
  }
  return text;
}

/// A line for each level of the load.
std::string points_text(const std::vector<bench::LoadPoint>& points) {
  std::string text;
  for (const bench::LoadPoint& point : points) {
    const bench::Report& report = point.report;
    text += fmt::format("  {:<18}{:>9.1f} frames/s, latency ms {}{}{}{}\n", point.label, report.frames_per_second(),
                        latency_text(report.latency),
                        report.failed() > 0 ? fmt::format("; {} failed", report.failed()) : "",
                        point.verdict.empty() ? "" : "; ", point.verdict);
  }
  return text;
}

/// How the results spread over several servers.
std::string servers_text(const bench::Report& report) {
  std::vector<std::string> servers;
  servers.reserve(report.results_of_server.size());
  for (const auto& [server, count] : report.results_of_server) {
    servers.push_back(fmt::format("{}: {} results", server, count));
  }
  return fmt::format("servers       {}\n", fmt::join(servers, ", "));
}

/// Where the time of a frame with a result goes.
std::string cost_text(const bench::LoadResult& result) {
  std::string text = "stages ms     ";
  for (std::size_t i = 0; i < bench::kStages.size(); ++i) {
    text += fmt::format("{}{} {:.2f}", i == 0 ? "" : ", ", bench::kStages[i], result.total.mean_stage_ms(i));
  }
  return text + fmt::format("\nthis process  {:.2f} ms of CPU a frame, {:.2f} CPUs busy\n", result.cpu_ms_per_frame(),
                            result.busy_cpus());
}

std::string search_text(const BenchSummary& summary) {
  if (!summary.capacity) return "";
  const bench::Capacity& capacity = *summary.capacity;
  if (capacity.low == 0) return fmt::format("capacity      no rate met {}\n", summary.search->text);
  const std::string above =
      std::isinf(capacity.high) ? "no rate that was tried missed it" : fmt::format("{:.1f} missed it", capacity.high);
  return fmt::format("capacity      {:.1f} frames/s met {}, {}; {} tries\n", capacity.low, summary.search->text, above,
                     capacity.tries.size());
}

/// Describes the figures that the server tells about itself.
std::string server_metrics_text(const bench::ServerMetrics& metrics) {
  constexpr const char* kQueueWait = "segserve_frame_queue_wait_seconds";
  const auto in_ms = [&](double percent) {
    const auto wait = metrics.percentile(kQueueWait, percent);
    return wait ? fmt::format("{:.1f}", 1000 * *wait) : "none";
  };
  std::string text = fmt::format("server        queue wait ms p50 {}, p99 {}", in_ms(50), in_ms(99));
  if (const auto cpu = metrics.cpu_ms_per_frame()) text += fmt::format("; {:.2f} ms of CPU a frame", *cpu);
  text += fmt::format("; at most {:.0f} MB resident", metrics.memory_bytes_max / 1e6);
  for (const auto& [cause, count] : metrics.growth_by("segserve_refusals_total", "cause")) {
    text += fmt::format("; {:.0f} refused for {}", count, cause);
  }
  return text + "\n";
}

std::string faults_text(const std::map<std::string, std::uint64_t>& faults) {
  std::vector<std::string> words;
  words.reserve(faults.size());
  for (const auto& [kind, count] : faults) words.push_back(fmt::format("{} {}", count, kind));
  return fmt::format("faults        {}\n", words.empty() ? "none" : fmt::format("{}", fmt::join(words, ", ")));
}

std::string objectives_text(const BenchSummary& summary) {
  std::string text;
  for (const bench::Objective& objective : summary.objectives) {
    const double reached = value(objective, summary.result.total);
    text += fmt::format("objective     {}: {} ({})\n", objective.text,
                        is_met(objective, summary.result.total) ? "met" : "MISSED",
                        std::isinf(reached) ? "frames failed" : fmt::format("{:.3f}", reached));
  }
  return text;
}

}  // namespace

std::string to_text(const BenchSummary& summary) {
  const bench::Report& total = summary.result.total;
  std::string text = load_text(summary);
  text += fmt::format("throughput    {}\n", throughput_text(total));
  text += fmt::format("latency ms    {}\n", latency_text(total.latency));
  text += fmt::format("since sent    {}", latency_text(total.since_sent));
  text += summary.load.is_open() ? fmt::format("; {} frames sent late\n", total.late) : "\n";
  text += codecs_text(summary) + points_text(summary.points);
  if (total.results > 0) text += cost_text(summary.result);
  if (summary.load.clients > 1) {
    text += fmt::format("fairness      the client with the fewest results got {:.0f} % of the mean\n",
                        total.least_share_percent());
  }
  if (total.results_of_server.size() > 1) text += servers_text(total);
  for (const auto& [key, count] : total.errors) text += fmt::format("error         {} times {}\n", count, key);
  if (total.repeated > 0) {
    text +=
        fmt::format("repeated      {} frames were sent more than once, {} of them to two servers at the same time\n",
                    total.repeated, total.hedged);
  }
  if (summary.load.verify) {
    text += fmt::format("verified      {} label arrays, {} differ\n", total.verified, total.mismatches);
  }
  if (summary.server_metrics) text += server_metrics_text(*summary.server_metrics);
  if (summary.faults) text += faults_text(*summary.faults);
  text += search_text(summary) + objectives_text(summary);
  for (const bench::Finding& finding : summary.findings) text += fmt::format("note          {}\n", finding.text);
  return text;
}

}  // namespace segserve::segctl
