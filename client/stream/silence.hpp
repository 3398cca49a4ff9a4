// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>
#include <optional>

#include "segserve/client/frame.hpp"

namespace segserve::client {

/// How long a connection may be silent that owes an answer.
struct SilenceLimits {
  Clock::duration until_probe;    ///< it is asked for a sign of life then
  Clock::duration until_suspect;  ///< after the probe: it gets no new frames
  Clock::duration until_dead;     ///< after the probe: it is given up
};

/// The limits of the only server, where there is nothing to gain by being hasty. `progress_timeout` as in
/// StreamOptions.
SilenceLimits silence_limits(std::chrono::milliseconds progress_timeout);

/// The limits of one of several servers. `usual` is what its frames take, zero if that is not known: on a slow link a
/// probe waits behind the payload of a frame.
SilenceLimits hasty_silence_limits(std::chrono::milliseconds progress_timeout, Clock::duration usual);

/// The silence of one connection. Knows no clock.
class Silence {
 public:
  explicit Silence(Time now) : last_sign_of_life_(now) {}

  void on_sign_of_life(Time now);
  /// The probe was answered, though what was asked before it was not. A server answers in order, so that another one
  /// answers for it behind a proxy. Unless there is a sign of life soon, it is dead.
  void on_answered_by_another(Time now);
  bool is_answered_by_another() const { return answered_by_another_at_.has_value(); }
  /// This process itself stood still for so long, and could not hear anything.
  void forgive(Clock::duration time, Time now);
  bool is_suspect() const { return is_suspect_; }

  enum class Verdict { kFine, kProbe, kDead };
  /// For a connection that owes an answer: kProbe once, when a probe is due; kDead when it was in vain.
  Verdict check(const SilenceLimits& limits, Time now);
  /// When to check again.
  Time due(const SilenceLimits& limits) const;

 private:
  Time last_sign_of_life_;
  std::optional<Time> probed_at_;  // unset: there was a sign of life since the last probe
  std::optional<Time> answered_by_another_at_;
  bool is_suspect_ = false;
};

/// Notices that this process stood still, because its checks come much later than they were due.
class SilenceClock {
 public:
  /// A check takes place. Returns for how long this process stood still before it, which is zero as a rule.
  Clock::duration check(Time now);
  /// The next check is due then.
  void set_due(std::optional<Time> due) { due_ = due; }

 private:
  std::optional<Time> due_;
};

}  // namespace segserve::client
