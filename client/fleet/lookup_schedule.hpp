// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <optional>
#include <random>

#include "segserve/client/frame.hpp"

namespace segserve::client {

/// Says when a name is looked up: at once, then about every 10 s. For a while after a change, an error of a lookup, or
/// trouble with a server, it is about every 2 s. Waits are random, so that the clients of a fleet do not ask all at the
/// same time. Knows no clock.
class LookupSchedule {
 public:
  explicit LookupSchedule(std::uint32_t seed) : random_(seed) {}

  /// When the next lookup is due; nothing: at once.
  std::optional<Time> due() const;

  /// A lookup has ended, with addresses other than before if `is_news`, or with an error.
  void on_answer(bool is_news, Time now);
  /// A server cannot be reached, or is about to stop.
  void on_trouble(Time now);

 private:
  std::minstd_rand random_;
  std::optional<Time> last_;         // when the last lookup ended
  std::optional<Time> hurry_until_;  // unset: there is no reason to hurry
  double share_ = 1;                 // of the usual wait
};

}  // namespace segserve::client
