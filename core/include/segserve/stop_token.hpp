#pragma once

#include <atomic>
#include <chrono>
#include <cstdint>
#include <functional>
#include <optional>
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

}  // namespace segserve
