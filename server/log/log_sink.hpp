// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>

#include "absl/base/thread_annotations.h"
#include "core/base/mutex.hpp"
#include "spdlog/details/null_mutex.h"
#include "spdlog/sinks/base_sink.h"

namespace segserve::server {

/// Writes lines to a file descriptor, on the one thread of an asynchronous logger. If the reader is slow, only that
/// thread waits. Lines that the logger's queue lost in the meantime are told in a line of their own. If the reader has
/// gone, lines go nowhere.
class LogSink final : public spdlog::sinks::base_sink<spdlog::details::null_mutex> {
 public:
  /// `lost_lines` tells how many messages the queue has lost so far. `file` stays open. The level is colored on a
  /// terminal.
  LogSink(int file, std::unique_ptr<spdlog::formatter> formatter, std::function<std::size_t()> lost_lines);

  /// Flushes that have reached this sink. Any thread may ask.
  std::uint64_t flushes() const;
  /// Waits until that number exceeds `before`; false if it does not within `time`.
  bool wait_for_flush(std::uint64_t before, std::chrono::milliseconds time);

 private:
  void sink_it_(const spdlog::details::log_msg& message) override;
  void flush_() override;
  void tell_lost_lines();
  void write_line(const spdlog::details::log_msg& message);

  const int file_;
  const bool is_terminal_;
  const std::function<std::size_t()> lost_lines_;
  std::size_t told_lost_lines_ = 0;
  mutable Mutex mutex_of_flushes_;
  CondVar flushed_;
  std::uint64_t flushes_ ABSL_GUARDED_BY(mutex_of_flushes_) = 0;
};

}  // namespace segserve::server
