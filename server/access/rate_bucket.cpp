// SPDX-License-Identifier: Apache-2.0
#include "server/access/rate_bucket.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>

namespace segserve::server {

void RateBucket::set_rate(double rate, Time now) {
  fill(now);
  rate_ = rate;
  level_ = std::min(level_, burst());
}

std::chrono::milliseconds RateBucket::wait_for(double amount, Time now) {
  if (std::isinf(rate_)) return {};
  fill(now);
  return time_for(std::min(amount, burst()) - level_);
}

std::chrono::milliseconds RateBucket::wait_in_line(double amount, Time now) {
  const auto alone = wait_for(amount, now);
  const auto wait = alone + time_for(std::fmod(line_, burst()));
  line_ += std::min(amount, burst());
  return wait;
}

std::chrono::milliseconds RateBucket::time_for(double amount) const {
  constexpr double kRounding = 1e-6, kLongestMs = 86'400'000;
  if (amount <= kRounding) return {};
  return std::chrono::milliseconds(static_cast<std::int64_t>(std::min(kLongestMs, std::ceil(amount / rate_ * 1000))));
}

void RateBucket::take(double amount) {
  level_ -= amount;
  line_ = 0;
}

void RateBucket::give_back(double amount) { level_ = std::min(burst(), level_ + amount); }

bool RateBucket::is_full(Time now) {
  fill(now);
  return level_ >= burst();
}

void RateBucket::fill(Time now) {
  const double seconds = std::chrono::duration<double>(now - filled_at_).count();
  if (seconds <= 0) return;
  level_ = std::min(burst(), level_ + rate_ * seconds);
  filled_at_ = now;
}

}  // namespace segserve::server
