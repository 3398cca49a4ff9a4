// SPDX-License-Identifier: Apache-2.0
#include "server/traces/span_exporter.hpp"

#include <algorithm>
#include <array>
#include <iterator>
#include <string>
#include <utility>

#include "absl/status/status.h"
#include "fmt/format.h"
#include "server/frames/catch_exceptions.hpp"
#include "server/log/log_event.hpp"
#include "server/traces/otlp_json.hpp"

namespace segserve::server {
namespace {

using Clock = std::chrono::steady_clock;

constexpr long kTooManyRequests = 429, kBadGateway = 502, kUnavailable = 503, kGatewayTimeout = 504;
constexpr std::chrono::seconds kLongestBackoff{30};
constexpr std::chrono::milliseconds kBackoffAtTheEnd{100};
constexpr std::chrono::seconds kBetweenReports{10}, kBetweenComplaints{60};

bool is_success(long status) { return status / 100 == 2; }

bool is_worth_another(long status) {
  return status == 0 || status == kTooManyRequests || status == kBadGateway || status == kUnavailable ||
         status == kGatewayTimeout;
}

std::string complaint_of(const HttpAnswer& answer) {
  return answer.status == 0 ? answer.error : fmt::format("the collector answers with HTTP {}", answer.status);
}

std::vector<Span> spans_of_all(const std::vector<TracedFrame>& batch) {
  std::vector<Span> all;
  for (const TracedFrame& frame : batch) std::ranges::move(spans_of(frame), std::back_inserter(all));
  return all;
}

}  // namespace

SpanExporter::SpanExporter(OtlpSettings settings, const ExportPace& pace)
    : settings_(std::move(settings)),
      pace_(pace),
      http_(settings_.url, settings_.headers, settings_.ca_file),
      thread_([this] { run(); }) {}

SpanExporter::~SpanExporter() {
  {
    const MutexLock lock(mutex_);
    stopping_ = true;
    end_ = Clock::now() + pace_.flush_time;
    changed_.notify_all();
  }
  http_.wake();
  thread_.join();
}

void SpanExporter::add(TracedFrame frame) {
  const MutexLock lock(mutex_);
  if (waiting_.size() >= kMostWaiting) {
    ++lost_;
    return;
  }
  waiting_.push_back(std::move(frame));
  if (waiting_.size() == 1 || waiting_.size() == kMostInBatch) changed_.notify_all();
}

void SpanExporter::run() {
  while (true) {
    Batch batch;
    const absl::Status sent = catch_exceptions("send traces", [&] {
      batch = take_batch();
      if (!batch.empty()) send(batch);
      return absl::OkStatus();
    });
    if (!sent.ok()) lost_ += batch.size();
    const bool is_over = sent.ok() && batch.empty();
    tell_losses(is_over);
    if (is_over) return;
  }
}

SpanExporter::Batch SpanExporter::take_batch() {
  const MutexLock lock(mutex_);
  while (waiting_.empty() && !stopping_) changed_.wait(mutex_);
  const Time full_at = Clock::now() + pace_.batch_delay;
  while (waiting_.size() < kMostInBatch && !stopping_ && changed_.wait_until(mutex_, full_at)) {
  }
  if (Clock::now() >= end_.load()) {
    lost_ += waiting_.size();
    waiting_.clear();
  }
  const auto count = static_cast<std::ptrdiff_t>(std::min(waiting_.size(), kMostInBatch));
  Batch batch(std::make_move_iterator(waiting_.begin()), std::make_move_iterator(waiting_.begin() + count));
  waiting_.erase(waiting_.begin(), waiting_.begin() + count);
  return batch;
}

void SpanExporter::send(const Batch& batch) {
  const std::string body = export_request(settings_.resource, spans_of_all(batch));
  for (std::uint32_t attempts = 1;; ++attempts) {
    const Time timeout = Clock::now() + pace_.answer_timeout;
    const HttpAnswer answer = http_.post(body, [&] { return std::min(timeout, end_.load()); });
    if (is_success(answer.status)) {
      exported_ += batch.size();
      if (const auto failure = partial_failure(answer.body)) complain(*failure);
      return;
    }
    complain(complaint_of(answer));
    const bool is_given_up = !is_worth_another(answer.status) || attempts >= pace_.attempts;
    if (is_given_up || !back_off(attempts, answer)) {
      lost_ += batch.size();
      return;
    }
  }
}

bool SpanExporter::back_off(std::uint32_t attempts, const HttpAnswer& answer) {
  std::chrono::milliseconds wait =
      std::min<std::chrono::milliseconds>(pace_.first_backoff * (1U << (attempts - 1)), kLongestBackoff);
  wait = std::chrono::milliseconds(std::uniform_int_distribution(wait.count() / 2, wait.count())(random_));
  if (answer.retry_after) wait = std::min<std::chrono::milliseconds>(*answer.retry_after, kLongestBackoff);
  const Time next = Clock::now() + wait;
  const MutexLock lock(mutex_);
  while (!stopping_ && changed_.wait_until(mutex_, next)) {
  }
  if (!stopping_) return true;
  const Time soon = std::min(next, Clock::now() + kBackoffAtTheEnd);
  if (soon >= end_.load()) return false;
  while (changed_.wait_until(mutex_, soon)) {
  }
  return true;
}

void SpanExporter::complain(const std::string& why) {
  const Time now = Clock::now();
  if (now < next_complaint_) return;
  next_complaint_ = now + kBetweenComplaints;
  const std::array fields{LogField("error", why)};
  log_event(spdlog::level::warn, "the collector of traces does not take them all", fields);
}

void SpanExporter::tell_losses(bool is_over) {
  const std::uint64_t lost = lost_;
  if (lost == told_lost_ || (!is_over && Clock::now() < next_report_)) return;
  const std::array fields{LogField("frames", lost - told_lost_)};
  log_event(spdlog::level::warn, "traces of frames were lost", fields);
  told_lost_ = lost;
  next_report_ = Clock::now() + kBetweenReports;
}

}  // namespace segserve::server
