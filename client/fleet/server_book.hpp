// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>
#include <cstdint>
#include <map>
#include <optional>
#include <random>
#include <vector>

#include "client/fleet/server_list.hpp"
#include "segserve/client/stream_options.hpp"

namespace segserve::client {

/// Remembers which servers of a list have failed, and when each may be tried again. Knows no clock.
class ServerBook {
 public:
  /// `seed` makes waits random.
  ServerBook(const RetryOptions& retry, std::uint32_t seed) : retry_(retry), random_(seed) {}

  /// Replaces the list. What is known about servers that stay on it is kept.
  void set_servers(const std::vector<Server>& servers);

  /// The server could not be reached, broke the connection, or refuses us, and may have asked to wait.
  void failed(ServerId server, Time now, std::optional<std::chrono::milliseconds> asked_for);
  /// The server answered.
  void reached(ServerId server);

  /// When a server may be tried again; Time{} if it has not failed.
  Time not_before(ServerId server) const;
  /// Whether the server has failed since it was reached last.
  bool is_failing(ServerId server) const;
  /// True if there are servers, and each has failed since it was reached last.
  bool nobody_in_reach() const;

 private:
  struct Entry {
    std::uint32_t failures = 0;  // since it was reached last
    Time not_before = {};
  };
  RetryOptions retry_;
  std::minstd_rand random_;
  std::map<ServerId, Entry> entries_;
};

}  // namespace segserve::client
