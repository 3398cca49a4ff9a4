// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <atomic>
#include <csignal>

namespace segserve::segctl {

/// While it lives, the first SIGINT (Ctrl-C) or SIGTERM sets a flag instead of ending the process. The second one ends
/// it as usual. Only one may live at a time.
class Interrupt {
 public:
  Interrupt();
  Interrupt(const Interrupt&) = delete;
  Interrupt& operator=(const Interrupt&) = delete;
  ~Interrupt();

  /// Stays set once it is set, as StopToken wants it.
  const std::atomic<bool>& flag() const;
  bool came() const { return flag(); }

  /// The flag of the one that lives. It is not set if there is none, because the signal then ends the process.
  static const std::atomic<bool>& signal_flag();

 private:
  struct sigaction old_int_ {
  }, old_term_{};
};

}  // namespace segserve::segctl
