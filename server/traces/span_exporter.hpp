// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <atomic>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <random>
#include <string>
#include <thread>
#include <vector>

#include "absl/base/thread_annotations.h"
#include "core/base/mutex.hpp"
#include "server/traces/frame_spans.hpp"
#include "server/traces/http_post.hpp"
#include "server/traces/otlp_settings.hpp"

namespace segserve::server {

/// The times that an exporter waits.
struct ExportPace {
  std::chrono::milliseconds batch_delay{1000};       ///< for a batch to become full
  std::chrono::milliseconds answer_timeout{10'000};  ///< for an answer of the collector
  std::chrono::milliseconds first_backoff{1000};     ///< before a batch is sent again; it doubles each time
  std::chrono::milliseconds flush_time{2000};        ///< for what is left when the exporter ends
  std::uint32_t attempts = 5;                        ///< for a batch; then it is lost
};

/// Sends the spans of frames to a collector by OTLP over HTTP, on a thread of its own. However slow the collector is,
/// frames wait for nothing: beyond kMostWaiting of them, further ones are lost, which the log tells. Batches are sent
/// again when the collector is out of reach or says that it is busy. Thread-safe.
class SpanExporter {
 public:
  static constexpr std::size_t kMostWaiting = 2048, kMostInBatch = 128;

  explicit SpanExporter(OtlpSettings settings, const ExportPace& pace = {});
  /// Sends what waits, for at most ExportPace::flush_time.
  ~SpanExporter();
  SpanExporter(const SpanExporter&) = delete;
  SpanExporter& operator=(const SpanExporter&) = delete;

  void add(TracedFrame frame);

  /// Frames whose spans the collector has taken, and frames whose spans are lost.
  std::uint64_t exported() const { return exported_; }
  std::uint64_t lost() const { return lost_; }

 private:
  using Time = std::chrono::steady_clock::time_point;
  using Batch = std::vector<TracedFrame>;

  void run();
  /// Waits for a batch; it is empty only when the exporter ends.
  Batch take_batch();
  /// Sends it until it is taken or lost.
  void send(const Batch& batch);
  /// Waits before another attempt; false if there is no time for one.
  bool back_off(std::uint32_t attempts, const HttpAnswer& answer);
  void complain(const std::string& why);
  void tell_losses(bool is_over);

  const OtlpSettings settings_;
  const ExportPace pace_;
  HttpPost http_;
  std::atomic<std::uint64_t> exported_{0}, lost_{0};
  std::atomic<Time> end_{Time::max()};  // by then the thread must have ended

  // The next are the thread's.
  std::minstd_rand random_{std::random_device()()};
  std::uint64_t told_lost_ = 0;
  Time next_report_{}, next_complaint_{};

  mutable Mutex mutex_;
  CondVar changed_;
  std::deque<TracedFrame> waiting_ ABSL_GUARDED_BY(mutex_);
  bool stopping_ ABSL_GUARDED_BY(mutex_) = false;
  std::thread thread_;  // is started last
};

}  // namespace segserve::server
