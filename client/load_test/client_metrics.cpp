// SPDX-License-Identifier: Apache-2.0
#include "client/load_test/client_metrics.hpp"

#include <array>
#include <cstdint>
#include <string_view>

#include "client/load_test/process_cost.hpp"
#include "fmt/format.h"

namespace segserve::bench {
namespace {

// Seconds. Latencies of small frames on one machine, up to those of large clouds over a slow link.
constexpr std::array<double, 14> kBounds = {0.001, 0.0025, 0.005, 0.01, 0.025, 0.05, 0.1, 0.25, 0.5, 1, 2.5, 5, 10, 30};

void add_head(std::string& text, std::string_view name, std::string_view type, std::string_view help) {
  text += fmt::format("# HELP {0} {2}\n# TYPE {0} {1}\n", name, type, help);
}

void add_value(std::string& text, std::string_view name, std::string_view type, std::string_view help, double value) {
  add_head(text, name, type, help);
  text += fmt::format("{} {}\n", name, value);
}

/// Text between quotes.
std::string escaped(std::string_view label) {
  std::string out;
  for (const char c : label) {
    if (c == '"' || c == '\\') out += '\\';
    out += c == '\n' ? ' ' : c;
  }
  return out;
}

/// Values that a bucket of the HDR histogram spreads over a bound count as beyond it.
void add_latencies(std::string& text, const HdrHistogram& histogram) {
  constexpr std::string_view kName = "segctl_bench_latency_seconds";
  add_head(text, kName, "histogram", "Time from when a frame was due to its decoded result.");
  std::size_t index = 0;
  std::uint64_t below = 0;
  const auto& counts = histogram.counts();
  for (const double bound : kBounds) {
    while (index < counts.size() && static_cast<double>(HdrHistogram::highest_of(index)) <= 1e6 * bound) {
      below += counts[index++];
    }
    text += fmt::format("{}_bucket{{le=\"{}\"}} {}\n", kName, bound, below);
  }
  text += fmt::format("{0}_bucket{{le=\"+Inf\"}} {1}\n{0}_sum {2}\n{0}_count {1}\n", kName, histogram.count(),
                      histogram.mean() * static_cast<double>(histogram.count()) / 1e6);
}

}  // namespace

std::string client_metrics_text(const Report& report) {
  std::string text;
  constexpr std::string_view kFrames = "segctl_bench_frames_total";
  add_head(text, kFrames, "counter", "Frames of the measured window that ended, by outcome.");
  text += fmt::format("{0}{{outcome=\"result\"}} {1}\n{0}{{outcome=\"failed\"}} {2}\n{0}{{outcome=\"dropped\"}} {3}\n",
                      kFrames, report.results, report.failed(), report.dropped);
  constexpr std::string_view kErrors = "segctl_bench_errors_total";
  add_head(text, kErrors, "counter", "Frames without a result, by outcome, code and reason.");
  for (const auto& [error, count] : report.errors) {
    text += fmt::format("{}{{error=\"{}\"}} {}\n", kErrors, escaped(error), count);
  }
  add_latencies(text, report.latency.histogram());
  add_value(text, "segctl_bench_late_frames_total", "counter", "Frames that were sent more than 1 ms late.",
            static_cast<double>(report.late));
  add_value(text, "segctl_bench_sent_bytes_total", "counter", "Bytes of frames with a result.",
            static_cast<double>(report.bytes_up));
  add_value(text, "segctl_bench_received_bytes_total", "counter", "Bytes of results.",
            static_cast<double>(report.bytes_down));
  add_value(text, "process_cpu_seconds_total", "counter", "Total user and system CPU time spent in seconds.",
            cpu_seconds());
  add_value(text, "process_resident_memory_bytes", "gauge", "Resident memory size in bytes.",
            static_cast<double>(resident_bytes()));
  return text;
}

}  // namespace segserve::bench
