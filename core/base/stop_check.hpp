// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <type_traits>

#include "absl/status/status.h"
#include "segserve/stop_token.hpp"

namespace segserve {

/// Counts the work that one thread does within a stage, and looks at the token now and then. A stage uses one object
/// from its beginning to its end, because each object lets some work pass before its first look.
///
///     absl::Status some_stage(const FrameContext& frame, const VoxelGrid& grid, Output& output) {
///       StopCheck check(frame.stop);
///       check.for_each(0, grid.size(), [&](std::size_t v) { ... });  // skipped once the frame is stopped
///       return check.status();
///     }
class StopCheck {
 public:
  /// `threads` is the number of threads that work on the stage at the same time, each with a StopCheck.
  explicit StopCheck(const StopToken& stop, unsigned threads = 1)
      : stop_(stop), interval_(std::min<std::uint64_t>(kInterval, StopToken::kMostWorkAfterStop / 2 / threads)) {}
  ~StopCheck() { report(); }
  StopCheck(const StopCheck&) = delete;
  StopCheck& operator=(const StopCheck&) = delete;

  /// Counts `units` of work that were done, or that come next. Returns whether the thread must leave the stage.
  bool after(std::uint64_t units) {
    pending_ += units;
    return pending_ >= interval_ ? look() : stopped_;
  }
  /// Whether the last look told the thread to leave the stage.
  bool stopped() const { return stopped_; }
  /// The status that a stage ends with, after another look at the token: OK, CANCELLED or DEADLINE_EXCEEDED.
  absl::Status status() {
    report();
    return stop_.check();
  }

  /// Calls each(first, last) for consecutive blocks of [begin, end), until it is stopped. An index counts as one unit
  /// of work. This serves small loops, whose variables then stay in registers.
  template <typename Each>
  bool for_each_block(std::size_t begin, std::size_t end, Each&& each) {
    while (begin < end && !stopped_) {
      const std::size_t last = std::min<std::size_t>(end, begin + interval_);
      each(begin, last);
      after(last - begin);
      begin = last;
    }
    return !stopped_;
  }

  /// Calls each(i) for the indices i in [begin, end), until it is stopped. each(i) may return the units of work that
  /// it did; without a result it counts as one. Returns false if it was stopped.
  template <typename Each>
  bool for_each(std::size_t begin, std::size_t end, Each&& each) {
    std::size_t i = begin;
    while (i < end && !stopped_) {
      std::uint64_t done = 0;
      if constexpr (std::is_void_v<std::invoke_result_t<Each, std::size_t>>) {
        const std::size_t last = std::min<std::size_t>(end, i + interval_);
        done = last - i;
        for (; i < last; ++i) each(i);
      } else {
        for (; i < end && done < interval_; ++i) done += each(i);
      }
      after(done);
    }
    return !stopped_;
  }

 private:
  static constexpr std::uint64_t kInterval = 4096;

  bool look() {
    stopped_ = stopped_ || stop_.stopped();
    report();
    return stopped_;
  }
  void report() {
    if (stop_.meter_ != nullptr && pending_ > 0) stop_.meter_->report(pending_);
    pending_ = 0;
  }

  const StopToken& stop_;
  const std::uint64_t interval_;
  std::uint64_t pending_ = 0;
  bool stopped_ = false;
};

}  // namespace segserve
