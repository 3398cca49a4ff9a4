#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <type_traits>

#include "segserve/stop_token.hpp"

namespace segserve {

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
