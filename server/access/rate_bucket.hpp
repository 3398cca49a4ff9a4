// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>

namespace segserve::server {

/// Bounds how much of something is taken a second (a token bucket). It holds what one second brings, and at least 1.
/// More than it holds may be taken at once when it is full; what is missing then is a debt. Not thread-safe; it knows
/// no clock.
class RateBucket {
 public:
  using Time = std::chrono::steady_clock::time_point;

  /// `rate` is above 0, and may be infinite. The bucket is full.
  RateBucket(double rate, Time now) : rate_(rate), level_(burst()), filled_at_(now) {}

  double rate() const { return rate_; }
  void set_rate(double rate, Time now);

  /// How long it takes until so much may be taken if nobody takes anything before; 0 if it may be taken now.
  std::chrono::milliseconds wait_for(double amount, Time now);
  /// Does the same for somebody who has to wait, in line behind those who were told since something was taken last. So
  /// they do not all come back at once. The line holds what one second brings; who comes then begins another.
  std::chrono::milliseconds wait_in_line(double amount, Time now);
  /// Takes it, even if that makes a debt.
  void take(double amount);
  /// Gives back what was taken in vain.
  void give_back(double amount);
  bool is_full(Time now);

 private:
  double burst() const { return rate_ < 1 ? 1 : rate_; }
  void fill(Time now);
  std::chrono::milliseconds time_for(double amount) const;

  double rate_;
  double level_;
  double line_ = 0;  // what others wait for
  Time filled_at_;
};

}  // namespace segserve::server
