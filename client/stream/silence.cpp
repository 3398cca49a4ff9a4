// SPDX-License-Identifier: Apache-2.0
#include "client/stream/silence.hpp"

#include <algorithm>

namespace segserve::client {
namespace {

// The answers of one server to two questions do not come further apart than this.
constexpr std::chrono::milliseconds kApart{500};

}  // namespace

SilenceLimits silence_limits(std::chrono::milliseconds progress_timeout) {
  const auto half = progress_timeout / 2;
  return {.until_probe = half, .until_suspect = progress_timeout - half, .until_dead = progress_timeout - half};
}

SilenceLimits hasty_silence_limits(std::chrono::milliseconds progress_timeout, Clock::duration usual) {
  constexpr std::chrono::milliseconds kHasty{500};
  const Clock::duration until_probe = std::min(kHasty, progress_timeout / 2);
  const Clock::duration until_dead = progress_timeout - until_probe;
  return {.until_probe = until_probe,
          .until_suspect = std::min(std::max(until_probe, usual), until_dead),
          .until_dead = until_dead};
}

void Silence::on_sign_of_life(Time now) {
  last_sign_of_life_ = now;
  probed_at_.reset();
  answered_by_another_at_.reset();
  is_suspect_ = false;
}

void Silence::on_answered_by_another(Time now) { answered_by_another_at_ = now; }

void Silence::forgive(Clock::duration time, Time now) {
  last_sign_of_life_ = std::min(last_sign_of_life_ + time, now);
  if (probed_at_) probed_at_ = std::min(*probed_at_ + time, now);
  if (answered_by_another_at_) answered_by_another_at_ = std::min(*answered_by_another_at_ + time, now);
}

Silence::Verdict Silence::check(const SilenceLimits& limits, Time now) {
  if (answered_by_another_at_ && now >= *answered_by_another_at_ + kApart) return Verdict::kDead;
  if (!probed_at_) {
    if (now < last_sign_of_life_ + limits.until_probe) return Verdict::kFine;
    probed_at_ = now;
    return Verdict::kProbe;
  }
  is_suspect_ = now >= *probed_at_ + limits.until_suspect;
  return now >= *probed_at_ + limits.until_dead ? Verdict::kDead : Verdict::kFine;
}

Time Silence::due(const SilenceLimits& limits) const {
  if (!probed_at_) return last_sign_of_life_ + limits.until_probe;
  if (answered_by_another_at_) return *answered_by_another_at_ + kApart;
  return *probed_at_ + (is_suspect_ ? limits.until_dead : limits.until_suspect);
}

Clock::duration SilenceClock::check(Time now) {
  constexpr std::chrono::milliseconds kUsualDelay{250};
  const bool stood_still = due_ && now > *due_ + kUsualDelay;
  return stood_still ? now - *due_ : Clock::duration(0);
}

}  // namespace segserve::client
