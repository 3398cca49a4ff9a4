// SPDX-License-Identifier: Apache-2.0
#include "client/segctl/bench_measure.hpp"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <functional>
#include <iterator>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "client/load_test/arrivals.hpp"
#include "client/load_test/client_metrics.hpp"
#include "client/load_test/fault_injector.hpp"
#include "client/load_test/hdr_log.hpp"
#include "client/load_test/metrics_listener.hpp"
#include "client/load_test/plan.hpp"
#include "client/load_test/server_metrics.hpp"
#include "client/segctl/agent_group.hpp"
#include "client/segctl/bench_host.hpp"
#include "client/segctl/interrupt.hpp"
#include "client/segctl/live_terminal.hpp"
#include "client/segctl/messages.hpp"
#include "core/base/status_macros.hpp"
#include "core/base/status_text.hpp"
#include "fmt/format.h"

namespace segserve::segctl {
namespace {

/// Frames a second that were due in an open loop.
std::optional<double> offered_rate(const bench::LoadPlan& plan, const bench::FrameSource& source,
                                   const bench::Report& total) {
  const bench::LoadOptions& load = plan.load;
  if (!load.is_open()) return std::nullopt;
  if (load.replay_speed > 0) {
    const auto frames = static_cast<double>(load.clients * source.times.size());
    return frames * load.replay_speed / bench::round_seconds(source.times);
  }
  const bool is_constant = load.rates.size() == 1 && load.rates.front().from == load.rates.front().to;
  if (is_constant && !plan.search) return load.rates.front().from;
  return total.seconds > 0 ? static_cast<double>(total.sent) / total.seconds : 0;
}

double wall_clock_now() {
  return std::chrono::duration<double>(std::chrono::system_clock::now().time_since_epoch()).count();
}

/// The measured window so far, for the live view.
class LiveTotals {
 public:
  bench_report::LiveSnapshot snapshot(const bench::TimelineEntry& entry, const bench::HdrHistogram& latencies) {
    if (entry.t >= 0) all_.add(bench::Latencies(latencies, entry.failed));
    bench_report::LiveSnapshot shown;
    shown.t = entry.t;
    shown.seconds = entry.seconds;
    shown.offered = static_cast<double>(entry.offered);
    shown.results = static_cast<double>(entry.results);
    shown.failed = static_cast<double>(entry.failed);
    shown.p50_ms = entry.p50_ms;
    shown.p99_ms = entry.p99_ms;
    shown.all_results = all_.results();
    shown.all_failed = all_.failed();
    if (all_.results() > 0) {
      shown.all_p50_ms = all_.percentile(50);
      shown.all_p99_ms = all_.percentile(99);
    }
    return shown;
  }

 private:
  bench::Latencies all_;
};

/// A line about an interval of a soak.
void print_interval(const bench::TimelineEntry& entry) {
  const auto ms = [](std::optional<double> value) {
    if (!value) return std::string("-");
    return std::isinf(*value) ? std::string("never") : fmt::format("{:.1f}", *value);
  };
  const std::string line = fmt::format(
      "{:7.1f} min: {:.1f} frames/s due, {:.1f} results/s, {} failed; latency ms p50 {}, p99 {}, max {}; this process "
      "{:.2f} CPUs, {:.0f} MB\n",
      std::max(0.0, entry.t) / 60, static_cast<double>(entry.offered) / entry.seconds,
      static_cast<double>(entry.results) / entry.seconds, entry.failed, ms(entry.p50_ms), ms(entry.p99_ms),
      ms(entry.max_ms), entry.client_busy_cpus, static_cast<double>(entry.client_rss_bytes) / 1e6);
  std::fputs(line.c_str(), stderr);
}

/// The faults that --fault asks for; null without it.
absl::StatusOr<std::unique_ptr<bench::FaultInjector>> start_faults(const BenchArguments& arguments,
                                                                   const bench::LoadOptions& load,
                                                                   const bench::FrameSource& source) {
  if (arguments.fault.empty()) return nullptr;
  ASSIGN_OR_RETURN(const bench::FaultMix mix, bench::parse_fault_mix(arguments.fault));
  ASSIGN_OR_RETURN(client::Payload payload, source.encodings.front().encode(source.clouds.front()));
  return bench::FaultInjector::start(load.client, load.stream, mix, std::move(payload));
}

/// Runs loads in this process, or by the agents of --agents.
absl::StatusOr<bench::LoadRunner> make_runner(const BenchArguments& arguments, const bench::LoadPlan& plan,
                                              const bench::FrameSource& source) {
  if (arguments.agents.empty()) return bench::local_runner(plan, source);
  ASSIGN_OR_RETURN(const auto addresses, parse_agent_addresses("--agents", arguments.agents));
  ASSIGN_OR_RETURN(const std::string secret, arguments.agent_secret());
  std::vector<std::string> words = bench_words();
  // The agents' environment may name another server.
  if (!arguments.server.server_given()) words.push_back("--server=" + arguments.server.address());
  ASSIGN_OR_RETURN(auto agents, AgentGroup::connect(addresses, words, secret));
  return agents_runner(std::move(agents));
}

/// The metrics that --metrics asks for; null without it.
absl::StatusOr<std::unique_ptr<bench::ServerMonitor>> start_monitor(const BenchArguments& arguments) {
  if (arguments.metrics.empty()) return nullptr;
  const auto address = bench::parse_metrics_address(arguments.metrics);
  if (!address.ok()) return with_prefix("--metrics", address.status());
  return bench::ServerMonitor::start(*address);
}

/// Serves the metrics of this process at --metrics-listen; null without it.
absl::StatusOr<std::unique_ptr<bench::MetricsListener>> start_listener(const BenchArguments& arguments,
                                                                       bench::LoadObserver& observer) {
  if (arguments.metrics_listen.empty()) return nullptr;
  ASSIGN_OR_RETURN(const AgentAddress address, parse_agent_address("--metrics-listen", arguments.metrics_listen));
  auto listener = bench::MetricsListener::start(address.host, address.port);
  if (!listener.ok()) {
    return with_prefix(fmt::format("cannot serve metrics at {}", arguments.metrics_listen), listener.status());
  }
  if (address.port == "0") {
    print_warning(fmt::format("serves metrics at {}:{}", address.host, (*listener)->port()));
  }
  observer.on_start = [&server = **listener](std::function<bench::Report()> total) {
    server.set_page([total = std::move(total)] { return bench::client_metrics_text(total()); });
  };
  observer.on_end = [&server = **listener] { server.set_page(nullptr); };
  return listener;
}

void add_server_metrics(bench::ServerMonitor& monitor, BenchSummary& summary) {
  auto metrics = monitor.total();
  if (metrics.ok()) {
    summary.server_metrics = *std::move(metrics);
  } else {
    print_warning(message_of(metrics.status()));
  }
}

void add_faults(bench::FaultInjector& injector, BenchSummary& summary) {
  summary.faults = injector.stop();
  const auto found = summary.faults->find("malformed_not_refused");
  if (found == summary.faults->end()) return;
  summary.findings.push_back(
      {"FAULT_NOT_REFUSED", fmt::format("{} malformed frames got a result instead of an error.", found->second)});
}

void add_runs(const bench::LoadPlan& plan, const bench::FrameSource& source, bench::LoadRuns runs,
              BenchSummary& summary) {
  summary.load = plan.load;
  summary.load.clients = std::ranges::max(plan.client_counts);
  summary.search = plan.search;
  summary.offered = offered_rate(plan, source, runs.result.total);
  summary.result = std::move(runs.result);
  summary.points = std::move(runs.points);
  summary.capacity = std::move(runs.capacity);
  summary.findings = bench::findings(summary.load, summary.result);
  std::ranges::move(runs.findings, std::back_inserter(summary.findings));
}

}  // namespace

absl::Status measure(const BenchArguments& arguments, const bench::FrameSource& source, BenchSummary& summary,
                     std::string& hdr_log) {
  ASSIGN_OR_RETURN(bench::LoadPlan plan, arguments.plan());
  const Interrupt interrupt;
  plan.load.interrupt = &interrupt.flag();
  ASSIGN_OR_RETURN(const auto runner, make_runner(arguments, plan, source));
  ASSIGN_OR_RETURN(const auto monitor, start_monitor(arguments));
  ASSIGN_OR_RETURN(const auto faults, start_faults(arguments, plan.load, source));
  summary.host = host_json();
  summary.started = wall_clock_now();
  bench::HdrLog log(summary.started);

  LiveTerminal terminal(
      fmt::format("{} client{}, {}", arguments.clients, arguments.clients == "1" ? "" : "s", summary.codec()));
  LiveTotals totals;
  bench::LoadObserver observer;
  double window_began = -1, last_t = 0;
  if (!arguments.soaks()) {
    observer.on_progress = [&terminal](double share) { terminal.show_progress(share); };
  }
  observer.on_interval = [&](const bench::TimelineEntry& entry, const bench::HdrHistogram& latencies) {
    if (faults) faults->on_frames(entry.sent);
    if (arguments.soaks()) {
      print_interval(entry);
    } else {
      terminal.show(totals.snapshot(entry, latencies));
    }
    // The first interval of a run begins with it.
    if (window_began < 0 || entry.t < last_t) window_began = wall_clock_now() - entry.t - entry.seconds;
    last_t = entry.t;
    if (!arguments.hdr_log.empty() && entry.t >= 0) log.add(window_began + entry.t, entry.seconds, latencies);
  };
  ASSIGN_OR_RETURN(const auto listener, start_listener(arguments, observer));
  if (monitor) {
    plan.server_cpu_ms_per_frame = [&monitor]() -> std::optional<double> {
      const auto lap = monitor->lap();
      return lap.ok() ? lap->cpu_ms_per_frame() : std::nullopt;
    };
  }
  ASSIGN_OR_RETURN(bench::LoadRuns runs, bench::run_plan(plan, summary.objectives, runner, observer));
  add_runs(plan, source, std::move(runs), summary);
  if (faults) add_faults(*faults, summary);
  if (monitor) add_server_metrics(*monitor, summary);
  hdr_log = log.text();
  return absl::OkStatus();
}

}  // namespace segserve::segctl
