// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <memory>
#include <thread>
#include <vector>

#include "absl/status/statusor.h"
#include "client/fleet/host_lookup.hpp"
#include "client/fleet/server_directory.hpp"
#include "client/fleet/server_name.hpp"
#include "segserve/client/frame.hpp"

namespace segserve::client {

/// Looks up a name again and again, when LookupSchedule says so, on a thread of its own.
class NameWatcher {
 public:
  /// Takes an answer, and returns whether it differs from the one before. It is called on the watcher's thread.
  using OnAnswer = std::function<bool(const absl::StatusOr<std::vector<HostAddress>>&)>;

  NameWatcher(HostName name, HostLookup lookup, OnAnswer on_answer);
  NameWatcher(const NameWatcher&) = delete;
  NameWatcher& operator=(const NameWatcher&) = delete;
  /// Waits for `on_answer`, but not for a lookup: its thread then goes on alone until the system answers, and ends.
  ~NameWatcher();

  /// Tells of trouble with a server of this name, so that another look is worth while.
  void on_trouble(Time now);

 private:
  struct State;
  static void run(const std::shared_ptr<State>& state, const OnAnswer& on_answer);

  const std::shared_ptr<State> state_;
  std::thread thread_;
};

}  // namespace segserve::client
