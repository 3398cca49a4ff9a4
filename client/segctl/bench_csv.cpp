// SPDX-License-Identifier: Apache-2.0
#include "client/segctl/bench_csv.hpp"

#include <cmath>
#include <optional>

#include "fmt/format.h"

namespace segserve::segctl {
namespace {

std::string csv_figure(std::optional<double> value) {
  return value && std::isfinite(*value) ? fmt::format("{:.3f}", *value) : "";
}

}  // namespace

std::string bench_csv(const std::vector<bench::TimelineEntry>& timeline) {
  std::string text =
      "t,seconds,offered,sent,results,failed,late,p50_ms,p90_ms,p99_ms,max_ms,client_busy_cpus,client_rss_bytes\n";
  for (const bench::TimelineEntry& entry : timeline) {
    text += fmt::format("{:.3f},{:.3f},{},{},{},{},{},{},{},{},{},{:.3f},{}\n", entry.t, entry.seconds, entry.offered,
                        entry.sent, entry.results, entry.failed, entry.late, csv_figure(entry.p50_ms),
                        csv_figure(entry.p90_ms), csv_figure(entry.p99_ms), csv_figure(entry.max_ms),
                        entry.client_busy_cpus, entry.client_rss_bytes);
  }
  return text;
}

}  // namespace segserve::segctl
