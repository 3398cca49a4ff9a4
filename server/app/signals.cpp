// SPDX-License-Identifier: Apache-2.0
#include "server/app/signals.hpp"

#include <pthread.h>

#include "spdlog/spdlog.h"

namespace segserve::server {

sigset_t block_signals() {
  sigset_t signals;
  sigemptyset(&signals);
  for (const int signal : {SIGTERM, SIGINT, SIGQUIT, SIGHUP, SIGUSR1, SIGUSR2}) sigaddset(&signals, signal);
  pthread_sigmask(SIG_BLOCK, &signals, nullptr);
  return signals;
}

int wait_for_stop(const sigset_t& signals, ProgramLog& log) {
  while (true) {
    int signal = 0;
    sigwait(&signals, &signal);
    switch (signal) {
      case SIGUSR1:
      case SIGUSR2:
        log.change_level(signal == SIGUSR1);
        break;
      case SIGHUP:
        spdlog::info("SIGHUP changes nothing: files of certificates and tokens are read again by themselves");
        break;
      default:
        return signal;
    }
  }
}

}  // namespace segserve::server
