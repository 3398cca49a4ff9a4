// SPDX-License-Identifier: Apache-2.0
#include "client/segctl/server_metrics_json.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "nlohmann/json.hpp"

namespace segserve::segctl {
namespace {

using Json = nlohmann::ordered_json;

// The families of metrics that a reader may want beside the figures of the client.
constexpr std::array<std::string_view, 13> kFamilies = {"process_cpu_seconds_total",
                                                        "process_resident_memory_bytes",
                                                        "segserve_frames_total",
                                                        "segserve_frame_failures_total",
                                                        "segserve_refusals_total",
                                                        "segserve_memory_leased_bytes",
                                                        "segserve_memory_limit_bytes",
                                                        "segserve_queue_frames",
                                                        "segserve_received_bytes_total",
                                                        "segserve_sent_bytes_total",
                                                        "segserve_streams",
                                                        "segserve_workers",
                                                        "segserve_build_info"};

Json samples_json(const std::vector<bench::MetricSample>& samples) {
  Json json = Json::object();
  for (const bench::MetricSample& sample : samples) {
    const bool is_chosen = std::ranges::find(kFamilies, sample.name) != kFamilies.end();
    if (is_chosen && std::isfinite(sample.value)) json[sample.text()] = sample.value;
  }
  return json;
}

Json in_ms(std::optional<double> seconds) { return seconds ? Json(1000 * *seconds) : Json(); }

}  // namespace

Json server_metrics_json(const bench::ServerMetrics& metrics) {
  constexpr const char* kQueueWait = "segserve_frame_queue_wait_seconds";
  Json rejected = Json::object();
  for (const auto& [cause, count] : metrics.growth_by("segserve_refusals_total", "cause")) rejected[cause] = count;
  const auto cpu = metrics.cpu_ms_per_frame();
  return {{"before", samples_json(metrics.before)},
          {"after", samples_json(metrics.after)},
          {"queue_wait_ms",
           {{"p50", in_ms(metrics.percentile(kQueueWait, 50))}, {"p99", in_ms(metrics.percentile(kQueueWait, 99))}}},
          {"rejected", std::move(rejected)},
          {"cpu_seconds", metrics.growth("process_cpu_seconds_total")},
          {"cpu_ms_per_frame", cpu ? Json(*cpu) : Json()},
          {"memory_bytes_max", metrics.memory_bytes_max}};
}

}  // namespace segserve::segctl
