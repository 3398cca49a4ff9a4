// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "client/fleet/host_lookup.hpp"
#include "client/fleet/name_watcher.hpp"
#include "client/fleet/server_directory.hpp"
#include "client/fleet/server_list.hpp"
#include "core/base/mutex.hpp"
#include "segserve/client/frame.hpp"

namespace segserve::client {

/// The servers of a client, as the names among its addresses resolve now. Any number of threads may use it.
class Fleet {
 public:
  /// `addresses` as of parse_addresses. `looks_up` false: names are left to gRPC.
  Fleet(const std::vector<std::string>& addresses, bool looks_up, const HostLookup& lookup = look_up_host);
  Fleet(const Fleet&) = delete;
  Fleet& operator=(const Fleet&) = delete;

  ServerList servers() ABSL_LOCKS_EXCLUDED(mutex_);
  /// Waits until there are servers or, unless `patient`, trouble with a name. Returns what there is then, or when
  /// `until` has passed.
  ServerList wait_for_servers(Time until, bool patient) ABSL_LOCKS_EXCLUDED(mutex_);
  /// A server cannot be reached or is about to stop: names are looked up sooner.
  void on_trouble(Time now);

  /// `changed` is called after each change of the list, on a thread of the fleet, until unsubscribe() returns. Returns
  /// a number for that. Neither may be called with a lock that `changed` takes.
  std::uint64_t subscribe(std::function<void()> changed) ABSL_LOCKS_EXCLUDED(subscribers_mutex_);
  void unsubscribe(std::uint64_t subscription) ABSL_LOCKS_EXCLUDED(subscribers_mutex_);

 private:
  bool update(std::size_t name, const absl::StatusOr<std::vector<HostAddress>>& answer)
      ABSL_LOCKS_EXCLUDED(mutex_, subscribers_mutex_);

  Mutex mutex_;
  CondVar changed_;
  ServerDirectory directory_ ABSL_GUARDED_BY(mutex_);

  Mutex subscribers_mutex_;  // held while they are called
  std::map<std::uint64_t, std::function<void()>> subscribers_ ABSL_GUARDED_BY(subscribers_mutex_);
  std::uint64_t last_subscription_ ABSL_GUARDED_BY(subscribers_mutex_) = 0;

  std::vector<std::unique_ptr<NameWatcher>> watchers_;  // last, because their threads use the other members
};

}  // namespace segserve::client
