// SPDX-License-Identifier: Apache-2.0
#include "client/load_test/recorder.hpp"

#include <algorithm>
#include <chrono>
#include <utility>

namespace segserve::bench {
namespace {

using client::Clock;
using client::Outcome;
using client::OutcomeKind;
using client::Time;

double to_seconds(Clock::duration duration) { return std::chrono::duration<double>(duration).count(); }
double to_ms(Clock::duration duration) { return 1000 * to_seconds(duration); }

bool is_late(const SentFrame& frame) { return frame.actual - frame.intended > std::chrono::milliseconds(1); }

}  // namespace

Recorder::Recorder(const RunClock& clock, std::vector<Clock::duration> levels, std::size_t encodings,
                   std::size_t clients, double interval_s)
    : clock_(clock),
      levels_(std::move(levels)),
      encodings_(encodings),
      clients_(clients),
      reports_(levels_.size() * encodings),
      timeline_(interval_s, to_seconds(clock.measured_from() - clock.begin())) {}

double Recorder::since_measured(Time time) const { return to_seconds(time - clock_.measured_from()); }

std::optional<std::size_t> Recorder::level_at(Time time) const {
  if (!clock_.is_measured(time)) return std::nullopt;
  const auto level = std::ranges::upper_bound(levels_, time - clock_.measured_from());
  if (level == levels_.end()) return std::nullopt;
  return static_cast<std::size_t>(level - levels_.begin());
}

Report* Recorder::report_at(Time time, std::size_t encoding) {
  const auto level = level_at(time);
  return level ? &reports_[*level * encodings_ + encoding] : nullptr;
}

void Recorder::on_offered(Time intended) {
  const MutexLock lock(mutex_);
  timeline_.on_offered(since_measured(intended));
}

void Recorder::on_sent(const SentFrame& frame) {
  const MutexLock lock(mutex_);
  timeline_.on_sent(since_measured(frame.actual), is_late(frame));
}

void Recorder::on_outcome(const SentFrame& frame, const Outcome& outcome, FrameRecord record, Time now) {
  record.latency_ms = to_ms(now - frame.intended);
  record.total_ms = to_ms(now - frame.actual);
  // A frame that was segmented in this process has no header.
  record.since_sent_ms =
      outcome.report.header_sent == Time{} ? record.total_ms : to_ms(now - outcome.report.header_sent);
  record.client_encode_ms = frame.encode_ms;
  record.late_ms = to_ms(frame.actual - frame.intended);
  const bool has_result = outcome.kind == OutcomeKind::kResult;

  const MutexLock lock(mutex_);
  if (has_result) {
    timeline_.on_result(since_measured(now), record.latency_ms);
    if (Report* report = report_at(now, frame.encoding)) report->add_finished(frame.client, record.points);
  } else if (outcome.kind != OutcomeKind::kDropped) {
    timeline_.on_failed(since_measured(now));
  }
  if (Report* report = report_at(frame.intended, frame.encoding)) report->add(outcome, record);
}

void Recorder::on_lost(const SentFrame& frame, const std::string& why, Time now) {
  const MutexLock lock(mutex_);
  timeline_.on_failed(since_measured(now));
  if (Report* report = report_at(frame.intended, frame.encoding)) report->add_failure(why);
}

bool Recorder::close_interval(Time now, double cpu_seconds, std::uint64_t rss_bytes, bool at_once,
                              const IntervalSink& sink) {
  const MutexLock lock(mutex_);
  const double at = since_measured(now);
  if (at < timeline_.open_end() && !at_once) return false;
  const HdrHistogram latencies = timeline_.open_latencies();
  const TimelineEntry& entry = timeline_.close(at, cpu_seconds, rss_bytes);
  if (sink) sink(entry, latencies);
  return true;
}

Report Recorder::total() const {
  const MutexLock lock(mutex_);
  Report report;
  for (const Report& part : reports_) report.add(part);
  report.finished_of_client.resize(clients_);
  return report;
}

double Recorder::level_seconds(std::size_t level) const {
  const Clock::duration begin = level == 0 ? Clock::duration(0) : levels_[level - 1];
  const Clock::duration end = std::min(levels_[level], clock_.end() - clock_.measured_from());
  return std::max(0.0, to_seconds(end - begin));
}

std::vector<Report> Recorder::parts_of(std::size_t level) const {
  const double seconds = level_seconds(level);
  const MutexLock lock(mutex_);
  const auto first = reports_.begin() + static_cast<std::ptrdiff_t>(level * encodings_);
  std::vector<Report> parts(first, first + static_cast<std::ptrdiff_t>(encodings_));
  for (std::size_t i = 0; i < encodings_; ++i) {
    parts[i].seconds = seconds;
    parts[i].finished_of_client.resize(clients_);
  }
  return parts;
}

Report Recorder::of_level(std::size_t level) const {
  Report report;
  report.seconds = level_seconds(level);
  for (const Report& part : parts_of(level)) report.add(part);
  return report;
}

std::vector<TimelineEntry> Recorder::timeline() const {
  const MutexLock lock(mutex_);
  return timeline_.entries();
}

}  // namespace segserve::bench
