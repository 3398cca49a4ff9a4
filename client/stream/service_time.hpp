// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>
#include <optional>

namespace segserve::client {

/// How long frames take from the time when they are sent to their outcome, learned as TCP learns its timeout (RFC 6298,
/// section 2): a smoothed mean, and four times the smoothed deviation from it.
class ServiceTime {
 public:
  using Duration = std::chrono::nanoseconds;

  /// A frame took so long. `least_weight`, 0 to 1, makes it count for more than RFC 6298 does.
  void add(Duration took, double least_weight = 0);
  /// A frame took at least so long, and was given up then.
  void add_at_least(Duration time, double least_weight = 0);
  /// Zero if none has come yet.
  Duration mean() const { return mean_.value_or(Duration(0)); }
  /// A time that few frames exceed; zero if none has come yet.
  Duration bound() const { return mean_ ? *mean_ + 4 * deviation_ : Duration(0); }

 private:
  std::optional<Duration> mean_;
  Duration deviation_{};
};

}  // namespace segserve::client
