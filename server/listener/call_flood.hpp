// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <atomic>
#include <chrono>
#include <cstdint>
#include <map>
#include <string>
#include <string_view>
#include <unordered_map>

#include "absl/base/thread_annotations.h"
#include "core/base/mutex.hpp"

namespace segserve::server {

/// Tells which connections flood the server with calls. A client of HTTP/2 may open a call, reset it and open the next,
/// as fast as it can write (CVE-2023-44487), and gRPC 1.51 keeps some 20 kB of each until it has found time to begin
/// and to end it. Without resets a connection has no more calls than it may have at a time. Thread-safe; it knows no
/// clock.
class CallFlood {
 public:
  struct Limits {
    std::int64_t calls = 128;              ///< a connection may have at a time; those beyond are in excess
    std::int64_t excess = 512;             ///< of all connections of an address
    std::int64_t rate = 2000;              ///< calls of an address that begin in a second
    std::int64_t waiting = 1024;           ///< calls that have arrived and not begun, of the whole server
    std::int64_t rate_in_need = 384;       ///< instead of `rate` while more wait, and for an address on probation
    std::int64_t few = 32;                 ///< so many calls a second of one connection have no part in a flood
    std::chrono::milliseconds hold{1000};  ///< new connections of an address that has flooded the server wait so long
    std::chrono::milliseconds probation{10'000};  ///< from then on
  };
  using Time = std::chrono::steady_clock::time_point;
  /// Names a call as long as it lasts.
  using Call = const void*;

  explicit CallFlood(const Limits& limits) : limits_(limits) {}

  void on_arrival() { ++waiting_; }
  /// A call begins that came by a connection of this peer, as gRPC names it. True if the connection floods the server.
  bool on_begin(Call call, std::string_view peer, Time now);
  /// A call ends, whether or not it has begun.
  void on_end(Call call);
  /// Whether an address, as client_address names it, has flooded the server a moment ago.
  bool is_held(const std::string& address, Time now) const;

 private:
  struct Connection {
    std::string address;
    std::int64_t calls = 0;
  };
  using Connections = std::map<std::string, Connection>;

  bool is_too_fast(const std::string& name, const std::string& address, Time now) ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);

  const Limits limits_;
  std::atomic<std::int64_t> waiting_{0};
  mutable Mutex mutex_;
  Connections connections_ ABSL_GUARDED_BY(mutex_);                                // that have calls, by name
  std::unordered_map<Call, Connections::iterator> calls_ ABSL_GUARDED_BY(mutex_);  // that have begun
  std::map<std::string, std::int64_t> excess_ ABSL_GUARDED_BY(mutex_);             // by address
  Time second_began_ ABSL_GUARDED_BY(mutex_);
  std::map<std::string, std::int64_t> begun_ ABSL_GUARDED_BY(mutex_);  // in this second, by connection and by address
  std::map<std::string, Time> flooded_at_ ABSL_GUARDED_BY(mutex_);     // by address, for the last time
};

}  // namespace segserve::server
