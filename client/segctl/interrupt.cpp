// SPDX-License-Identifier: Apache-2.0
#include "client/segctl/interrupt.hpp"

namespace segserve::segctl {
namespace {

std::atomic<bool> signal_came{false};
static_assert(std::atomic<bool>::is_always_lock_free, "a signal handler may use nothing else");

}  // namespace

Interrupt::Interrupt() {
  struct sigaction action {};
  action.sa_handler = [](int) { signal_came = true; };
  action.sa_flags = SA_RESTART | static_cast<int>(SA_RESETHAND);
  sigemptyset(&action.sa_mask);
  signal_came = false;
  sigaction(SIGINT, &action, &old_int_);
  sigaction(SIGTERM, &action, &old_term_);
}

Interrupt::~Interrupt() {
  sigaction(SIGINT, &old_int_, nullptr);
  sigaction(SIGTERM, &old_term_, nullptr);
  signal_came = false;
}

const std::atomic<bool>& Interrupt::flag() const { return signal_came; }

const std::atomic<bool>& Interrupt::signal_flag() { return signal_came; }

}  // namespace segserve::segctl
