#pragma once

#include <atomic>
#include <chrono>
#include <optional>

#include "absl/status/status.h"

namespace segserve {

/// Asks a running segmentation to end early. The caller owns the flag; both parts are optional.
class StopToken {
 public:
  using Clock = std::chrono::steady_clock;

  StopToken() = default;
  explicit StopToken(const std::atomic<bool>* cancelled, std::optional<Clock::time_point> deadline = std::nullopt)
      : cancelled_(cancelled), deadline_(deadline) {}

  /// CANCELLED, DEADLINE_EXCEEDED or OK. Called between stages and inside the long ones.
  absl::Status check() const;
  bool stopped() const { return !check().ok(); }

 private:
  const std::atomic<bool>* cancelled_ = nullptr;
  std::optional<Clock::time_point> deadline_;
};

}  // namespace segserve
