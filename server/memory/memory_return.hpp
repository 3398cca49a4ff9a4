// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>
#include <cstdint>

#include "server/memory/memory_ledger.hpp"

namespace segserve::server {

/// Makes malloc keep the buffers of clouds, which are megabytes, in the heap. By default it maps and unmaps each of
/// them, and every page faults anew, which slows the transport down a lot.
void keep_freed_memory();

/// Gives the memory that the calling thread has freed, and that malloc keeps for it, back to the system. malloc_trim
/// leaves the end of each thread's arena as it is.
void give_back_own_memory();

/// Gives memory that was freed, but that malloc keeps for later, back to the system when nobody has needed it for a
/// while. One thread at a time may use an object.
class MemoryReturn {
 public:
  using Time = std::chrono::steady_clock::time_point;

  /// The ledger must outlive this object.
  explicit MemoryReturn(const MemoryLedger& ledger) : ledger_(ledger) {}

  /// To be called now and then.
  void on_tick(Time now);

 private:
  const MemoryLedger& ledger_;
  Time next_look_{};
  std::uint64_t idle_looks_ = 0;      // in a row at which nothing was leased
  std::uint64_t least_resident_ = 0;  // bytes, after memory was given back
};

/// Bytes of memory that this process has now.
std::uint64_t resident_memory();

}  // namespace segserve::server
