// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <optional>
#include <random>
#include <vector>

#include "client/fleet/server_book.hpp"
#include "client/fleet/server_list.hpp"
#include "core/base/mutex.hpp"

namespace segserve::client {

/// Spreads the unary calls of a client over its servers. Any number of threads may use it.
class CallTurns {
 public:
  /// `seed` decides about the server that is first, which should differ between the processes of a machine.
  explicit CallTurns(std::uint32_t seed) : random_(seed) {}

  struct Choice {
    Server server;
    Time not_before = {};  ///< that it may be tried
  };
  /// The server that may be tried soonest, as `book` of this call says. Among several, it is one that has not failed
  /// other calls of late, with the fewest calls under way, and in turn. The call is under way until end(). `servers`
  /// may not be empty.
  Choice begin(const std::vector<Server>& servers, const ServerBook& book, Time now) ABSL_LOCKS_EXCLUDED(mutex_);
  /// A call has ended; `reached` false: without an answer from the server.
  void end(ServerId server, bool reached, Time now) ABSL_LOCKS_EXCLUDED(mutex_);

 private:
  struct Use {
    std::size_t under_way = 0;
    std::optional<Time> failed_at;  // unset: the last call reached it
    std::uint64_t turn = 0;         // of its last call; random before the first
  };
  Use& use_of(ServerId server) ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);

  Mutex mutex_;
  std::minstd_rand random_ ABSL_GUARDED_BY(mutex_);
  std::map<ServerId, Use> uses_ ABSL_GUARDED_BY(mutex_);
  std::uint64_t last_turn_ ABSL_GUARDED_BY(mutex_) = std::minstd_rand::max();
};

}  // namespace segserve::client
