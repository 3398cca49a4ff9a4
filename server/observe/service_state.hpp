// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>

#include "server/memory/memory_ledger.hpp"
#include "server/scheduling/worker_pool.hpp"

namespace segserve::server {

/// The state of a service at this moment. Reading it takes a few short locks and waits for nothing else.
struct ServiceState {
  PoolState pool;
  MemoryUse memory;
  std::size_t unary_calls = 0;  ///< that wait or are computed, or whose answers are not read yet
  std::size_t streams = 0;      ///< that are open
  bool is_draining = false;
  std::uint64_t access_reloads = 0;         ///< changed files of tokens and keys that were taken
  std::uint64_t failed_access_reloads = 0;  ///< and those that were refused for their faults
};

}  // namespace segserve::server
