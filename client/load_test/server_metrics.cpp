// SPDX-License-Identifier: Apache-2.0
#include "client/load_test/server_metrics.hpp"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdlib>
#include <limits>
#include <utility>

#include "core/base/status_macros.hpp"

namespace segserve::bench {
namespace {

constexpr std::chrono::milliseconds kPageTimeout{5000};
constexpr std::chrono::seconds kPageInterval{1};

bool has_labels(const MetricSample& sample, const std::map<std::string, std::string>& labels) {
  return std::ranges::all_of(labels, [&](const auto& wanted) {
    const auto found = sample.labels.find(wanted.first);
    return found != sample.labels.end() && found->second == wanted.second;
  });
}

double sum_of(const std::vector<MetricSample>& samples, const std::string& name,
              const std::map<std::string, std::string>& labels) {
  double sum = 0;
  for (const MetricSample& sample : samples) {
    if (sample.name == name && has_labels(sample, labels)) sum += sample.value;
  }
  return sum;
}

/// The growth by the value of a label, also where it is 0.
std::map<std::string, double> all_growth_by(const ServerMetrics& metrics, const std::string& name,
                                            const std::string& label) {
  std::map<std::string, double> all;
  for (const MetricSample& sample : metrics.after) {
    const auto found = sample.labels.find(label);
    if (sample.name != name || found == sample.labels.end() || all.contains(found->second)) continue;
    all[found->second] = metrics.growth(name, {{label, found->second}});
  }
  return all;
}

}  // namespace

double ServerMetrics::growth(const std::string& name, const std::map<std::string, std::string>& labels) const {
  return sum_of(after, name, labels) - sum_of(before, name, labels);
}

std::map<std::string, double> ServerMetrics::growth_by(const std::string& name, const std::string& label) const {
  std::map<std::string, double> all = all_growth_by(*this, name, label);
  std::erase_if(all, [](const auto& each) { return each.second <= 0; });
  return all;
}

std::optional<double> ServerMetrics::percentile(const std::string& histogram, double percent) const {
  std::map<double, double> cumulative;  // by upper bound
  for (const auto& [bound, count] : all_growth_by(*this, histogram + "_bucket", "le")) {
    cumulative[bound == "+Inf" ? std::numeric_limits<double>::infinity() : std::strtod(bound.c_str(), nullptr)] = count;
  }
  if (cumulative.empty() || cumulative.rbegin()->second <= 0) return std::nullopt;
  const double rank = percent / 100 * cumulative.rbegin()->second;
  double lower_bound = 0, below = 0;
  for (const auto& [bound, count] : cumulative) {
    if (count >= rank) {
      if (std::isinf(bound)) return lower_bound;  // more than the largest bucket tells
      return lower_bound + (bound - lower_bound) * (count > below ? (rank - below) / (count - below) : 1);
    }
    lower_bound = bound;
    below = count;
  }
  return lower_bound;
}

std::optional<double> ServerMetrics::cpu_ms_per_frame() const {
  const double results = growth("segserve_frames_total", {{"outcome", "result"}});
  if (results <= 0) return std::nullopt;
  return 1000 * growth("process_cpu_seconds_total") / results;
}

absl::StatusOr<std::unique_ptr<ServerMonitor>> ServerMonitor::start(MetricsAddress address) {
  ASSIGN_OR_RETURN(std::vector<MetricSample> first, read_metrics(address, kPageTimeout));
  return std::unique_ptr<ServerMonitor>(new ServerMonitor(std::move(address), std::move(first)));
}

ServerMonitor::ServerMonitor(MetricsAddress address, std::vector<MetricSample> first)
    : address_(std::move(address)), first_(std::move(first)), lap_began_(first_), thread_([this] { watch(); }) {}

ServerMonitor::~ServerMonitor() {
  {
    const MutexLock lock(mutex_);
    stopping_ = true;
    stopped_.notify_all();
  }
  thread_.join();
}

void ServerMonitor::watch() {
  while (true) {
    {
      const MutexLock lock(mutex_);
      const auto until = std::chrono::steady_clock::now() + kPageInterval;
      while (!stopping_ && stopped_.wait_until(mutex_, until)) {
      }
      if (stopping_) return;
    }
    const auto samples = read_metrics(address_, kPageTimeout);  // a page that does not come is no reason to end a run
    const MutexLock lock(mutex_);
    if (samples.ok()) look(*samples);
  }
}

void ServerMonitor::look(const std::vector<MetricSample>& samples) {
  memory_bytes_max_ = std::max(memory_bytes_max_, sum_of(samples, "process_resident_memory_bytes", {}));
}

absl::StatusOr<ServerMetrics> ServerMonitor::since(const std::vector<MetricSample>& begin) {
  ServerMetrics metrics;
  metrics.before = begin;
  ASSIGN_OR_RETURN(metrics.after, read_metrics(address_, kPageTimeout));
  const MutexLock lock(mutex_);
  look(metrics.before);
  look(metrics.after);
  metrics.memory_bytes_max = memory_bytes_max_;
  return metrics;
}

absl::StatusOr<ServerMetrics> ServerMonitor::total() { return since(first_); }

absl::StatusOr<ServerMetrics> ServerMonitor::lap() {
  ASSIGN_OR_RETURN(ServerMetrics metrics, since(lap_began_));
  lap_began_ = metrics.after;
  return metrics;
}

}  // namespace segserve::bench
