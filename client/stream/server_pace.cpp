// SPDX-License-Identifier: Apache-2.0
#include "client/stream/server_pace.hpp"

#include <chrono>
#include <cmath>

namespace segserve::client {

double ServerPace::share_left(Time now) const {
  constexpr double kHalfLife = 3;  // seconds
  if (!fades_ || !learned_at_ || now <= *learned_at_) return 1;
  return std::exp2(-std::chrono::duration<double>(now - *learned_at_).count() / kHalfLife);
}

void ServerPace::add(ServiceTime::Duration took, Time now) {
  time_.add(took, 1 - share_left(now));
  learned_at_ = now;
}

void ServerPace::add_at_least(ServiceTime::Duration time, Time now) {
  time_.add_at_least(time, 1 - share_left(now));
  learned_at_ = now;
}

ServiceTime::Duration ServerPace::expected(Time now) const {
  return std::chrono::duration_cast<ServiceTime::Duration>(time_.mean() * share_left(now));
}

}  // namespace segserve::client
