// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>
#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "server/listener/listener_probe.hpp"
#include "server/listener/watched_listener.hpp"
#include "server/scheduling/ticker.hpp"

namespace segserve::server {

/// Connects, on a thread of its own, to its own server again and again, because gRPC 1.51 may stop accepting
/// connections for good once the process has run out of file descriptors (CVE-2023-4785). It also warns when few of
/// these are left.
///
/// A listener that has accepted connections since the last probe is not deaf, however late it answers: clients that
/// flood it with connections keep its answers back, but must not end the server.
class ListenerWatch {
 public:
  /// Waits for `interval` between probes. A probe takes at most a second or two. `on_deaf` is called once, on the
  /// thread, after three probes of one listener in a row without an answer or another sign of life. No file descriptor
  /// for a probe counts as no answer, because then there is none for a client.
  ListenerWatch(const std::vector<WatchedListener>& listeners, std::chrono::milliseconds interval,
                std::function<void()> on_deaf);

 private:
  struct Watched {
    std::string name;  // for the log
    ListenerProbe probe;
    std::function<std::uint64_t()> accepted;
    std::uint64_t accepted_before;  // by the end of the last probe
    int unanswered = 0;             // probes in a row
  };

  static std::vector<Watched> watched(const std::vector<WatchedListener>& listeners);
  /// False once a listener is deaf.
  bool tick();
  bool is_deaf(Watched& listener) const;
  /// Whether the listener has accepted connections since this was asked last.
  static bool has_accepted(Watched& listener);

  const std::chrono::milliseconds patience_;
  const std::function<void()> on_deaf_;
  std::vector<Watched> listeners_;  // this and the next are the ticker's
  bool warned_ = false;             // of few descriptors
  Ticker ticker_;                   // is destroyed first
};

}  // namespace segserve::server
