// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>
#include <functional>

#include "server/listener/listener_probe.hpp"
#include "server/options/listen_address.hpp"
#include "server/scheduling/ticker.hpp"

namespace segserve::server {

/// Connects, on a thread of its own, to its own server again and again, because gRPC 1.51 may stop accepting
/// connections for good once the process has run out of file descriptors (CVE-2023-4785). It also warns when few of
/// these are left.
class ListenerWatch {
 public:
  /// Waits for `interval` between probes. A probe takes at most a second or two. `on_deaf` is called once, on the
  /// thread, after three probes in a row without an answer.
  ListenerWatch(ListenAddress address, int port, std::chrono::milliseconds interval, std::function<void()> on_deaf);

 private:
  /// False once the listener is deaf.
  bool tick();
  /// kUnknown if there is not even memory for a probe.
  Listener look();

  const ListenAddress address_;
  const int port_;
  const std::chrono::milliseconds patience_;
  const std::function<void()> on_deaf_;
  bool warned_ = false;  // of few descriptors; this and the next are the ticker's
  int unanswered_ = 0;   // probes in a row
  Ticker ticker_;        // is destroyed first
};

}  // namespace segserve::server
