// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <optional>
#include <utility>

#include "absl/base/thread_annotations.h"
#include "core/base/mutex.hpp"

namespace segserve::server {

class MemoryLedger;

/// Bytes of a MemoryLedger that belong to one thing. It gives them back when it is destroyed. One thread at a time may
/// use it; the ledger must outlive it.
class MemoryLease {
 public:
  MemoryLease() = default;
  MemoryLease(MemoryLease&& other) noexcept : ledger_(std::exchange(other.ledger_, nullptr)), bytes_(other.bytes_) {}
  MemoryLease& operator=(MemoryLease&& other) noexcept;
  ~MemoryLease() { release(); }

  std::uint64_t bytes() const { return ledger_ == nullptr ? 0 : bytes_; }
  /// Changes the number of bytes. A lease can always shrink. Returns false, and changes nothing, if it cannot grow.
  bool resize(std::uint64_t bytes);
  void release();

 private:
  friend class MemoryLedger;
  MemoryLease(MemoryLedger& ledger, std::uint64_t bytes) : ledger_(&ledger), bytes_(bytes) {}

  MemoryLedger* ledger_ = nullptr;
  std::uint64_t bytes_ = 0;
};

/// The memory that a server may use for its clients, and how much of it is leased: payloads as received, decoded
/// clouds, the workspace of segmentation, and results until they are read. Memory is leased before it is allocated.
/// Thread-safe.
class MemoryLedger {
 public:
  explicit MemoryLedger(std::uint64_t budget) : budget_(budget) {}

  /// nullopt if so many bytes are not free.
  std::optional<MemoryLease> lease(std::uint64_t bytes);

  std::uint64_t budget() const { return budget_; }
  std::uint64_t leased() const;

 private:
  friend class MemoryLease;
  /// Leases `after` bytes instead of `before`. False, without any change, if they are not free.
  bool change(std::uint64_t before, std::uint64_t after);

  const std::uint64_t budget_;
  mutable Mutex mutex_;
  std::uint64_t leased_ ABSL_GUARDED_BY(mutex_) = 0;
};

/// The memory that this process may use, bytes: the least of the limits of its cgroups, and of the machine's memory.
std::uint64_t available_memory();

}  // namespace segserve::server
