// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <atomic>
#include <chrono>
#include <cstdint>
#include <functional>
#include <optional>
#include <utility>

#include "absl/status/status.h"

namespace segserve {

/// Counts the work of a segmentation. One unit of work is one point, voxel, supervoxel or edge that one stage visits; a
/// neighbor that is looked at counts as an edge. Memory that is allocated, filled with one value or copied as it is
/// does not count.
class WorkMeter {
 public:
  /// `on_report` is called with the units counted so far, on the threads that work.
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

/// Asks a running segmentation to end early. The caller owns the flag and the meter, which must outlive the
/// segmentation; each of flag, deadline and meter is optional. The flag must stay set once it is set, because the
/// stages rely on a token that never takes a stop back.
class StopToken {
 public:
  using Clock = std::chrono::steady_clock;

  /// The units of work (WorkMeter) that all threads of a segmentation together do at most after it was asked to stop.
  static constexpr std::uint64_t kMostWorkAfterStop = 100'000;

  StopToken() = default;
  explicit StopToken(const std::atomic<bool>* cancelled, std::optional<Clock::time_point> deadline = std::nullopt,
                     WorkMeter* meter = nullptr)
      : cancelled_(cancelled), deadline_(deadline), meter_(meter) {}

  /// CANCELLED if the flag is set, DEADLINE_EXCEEDED if the deadline has passed, otherwise OK.
  absl::Status check() const;
  /// Whether `check` does not return OK.
  bool stopped() const;

 private:
  friend class StopCheck;
  const std::atomic<bool>* cancelled_ = nullptr;
  std::optional<Clock::time_point> deadline_;
  WorkMeter* meter_ = nullptr;
};

}  // namespace segserve
