#pragma once

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <optional>
#include <type_traits>
#include <utility>

#include "absl/status/status.h"

namespace segserve {

/// Counts the work of a segmentation. One unit: one point, voxel, supervoxel or edge visited by one stage (a neighbour
/// that is looked at counts as an edge). Memory that is allocated, filled with one value or copied as it is does not
/// count.
class WorkMeter {
 public:
  /// `on_report` is called, on the thread that works, with the units counted so far.
  explicit WorkMeter(std::function<void(std::uint64_t units)> on_report = nullptr) : on_report_(std::move(on_report)) {}

  void report(std::uint64_t units) {
    const std::uint64_t total = units_.fetch_add(units) + units;
    if (on_report_) on_report_(total);
  }
  std::uint64_t units() const { return units_; }

 private:
  std::function<void(std::uint64_t)> on_report_;
  std::atomic<std::uint64_t> units_{0};
};

/// Asks a running segmentation to end early. The caller owns flag and meter; all parts are optional. Once it says
/// stop it never goes back: the flag stays set, and so a stage that was left early is known by `check` after it.
class StopToken {
 public:
  using Clock = std::chrono::steady_clock;

  /// Units of work (see WorkMeter) that all threads of a segmentation together may still do after it was asked to stop.
  static constexpr std::uint64_t kMostWorkAfterStop = 100'000;

  StopToken() = default;
  explicit StopToken(const std::atomic<bool>* cancelled, std::optional<Clock::time_point> deadline = std::nullopt,
                     WorkMeter* meter = nullptr)
      : cancelled_(cancelled), deadline_(deadline), meter_(meter) {}

  /// CANCELLED, DEADLINE_EXCEEDED or OK. Called between stages and, by StopCheck, inside all of them.
  absl::Status check() const;
  bool stopped() const;

 private:
  friend class StopCheck;
  const std::atomic<bool>* cancelled_ = nullptr;
  std::optional<Clock::time_point> deadline_;
  WorkMeter* meter_ = nullptr;
};

/// Within a stage: counts the work of one thread and looks at the token now and then. One object for a whole stage, as
/// each does some work before its first look.
class StopCheck {
 public:
  /// `threads`: how many do this at the same time.
  explicit StopCheck(const StopToken& stop, unsigned threads = 1)
      : stop_(stop), interval_(std::min<std::uint64_t>(kInterval, StopToken::kMostWorkAfterStop / 2 / threads)) {}
  ~StopCheck() { report(); }
  StopCheck(const StopCheck&) = delete;
  StopCheck& operator=(const StopCheck&) = delete;

  /// `units` of work were done, or are done next. True: leave the stage.
  bool after(std::uint64_t units) {
    pending_ += units;
    return pending_ >= interval_ ? look() : stopped_;
  }
  /// Whether `after` has said so.
  bool stopped() const { return stopped_; }

  /// each(first, last) for consecutive blocks of [begin, end), one unit of work an index. For small loops: their
  /// variables stay in registers.
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

  /// each(i) for all i in [begin, end). What it returns is the work it did; nothing: one unit. False: it was left
  /// early.
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
