// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>
#include <functional>
#include <thread>

#include "absl/base/thread_annotations.h"
#include "core/base/mutex.hpp"
#include "server/listener/listener_probe.hpp"
#include "server/options/listen_address.hpp"

namespace segserve::server {

/// A thread that connects to its own server again and again, because gRPC 1.51 may stop accepting connections for good
/// once the process has run out of file descriptors (CVE-2023-4785). It also warns when few of these are left.
class ListenerWatch {
 public:
  /// Waits for `interval` between probes. A probe takes at most a second or two. `on_deaf` is called once, on the
  /// thread, after three probes in a row without an answer.
  ListenerWatch(ListenAddress address, int port, std::chrono::milliseconds interval, std::function<void()> on_deaf);
  ~ListenerWatch();
  ListenerWatch(const ListenerWatch&) = delete;
  ListenerWatch& operator=(const ListenerWatch&) = delete;

 private:
  void run();
  /// kUnknown if there is not even memory for a probe.
  Listener look(bool& warned);
  /// False if the thread shall end.
  bool wait();

  const ListenAddress address_;
  const int port_;
  const std::chrono::milliseconds interval_;
  const std::function<void()> on_deaf_;
  Mutex mutex_;
  CondVar stop_requested_;
  bool stopping_ ABSL_GUARDED_BY(mutex_) = false;
  std::thread thread_;
};

}  // namespace segserve::server
