// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <map>
#include <optional>
#include <string>
#include <utility>

#include "absl/base/thread_annotations.h"
#include "core/base/mutex.hpp"

namespace segserve::server {

class MemoryLedger;

/// Whose a lease is.
struct MemoryOwner {
  std::string address;  ///< of the machine, see client_address
  std::string stream;   ///< the stream, or the connection of a unary call
};

/// The purpose of leased memory.
enum class LeaseKind : std::uint8_t {
  kWaiting,    ///< the payload of a frame that is being uploaded or waits for a worker
  kComputing,  ///< the cloud and the workspace of a frame that a worker has, with its payload
  kResult,     ///< a result that its client has not read yet
};
inline constexpr std::size_t kLeaseKinds = 3;

/// The memory that a ledger has leased at this moment.
struct MemoryUse {
  std::uint64_t budget = 0;                         ///< bytes
  std::array<std::uint64_t, kLeaseKinds> leased{};  ///< bytes, by LeaseKind
  std::uint64_t refusals = 0;                       ///< leases that were not given or could not grow, so far
  bool is_short = false;                            ///< see MemoryLedger::is_short
};

/// Bytes of a MemoryLedger that belong to one thing. It gives them back when it is destroyed. One thread at a time may
/// use it; the ledger must outlive it.
class MemoryLease {
 public:
  MemoryLease() = default;
  MemoryLease(MemoryLease&& other) noexcept;
  MemoryLease& operator=(MemoryLease&& other) noexcept;
  ~MemoryLease() { release(); }

  std::uint64_t bytes() const { return ledger_ == nullptr ? 0 : bytes_; }
  /// Changes the number of bytes, for something that does not wait any more. A lease can always shrink. Returns false,
  /// and changes nothing, if it cannot grow.
  bool resize(std::uint64_t bytes, LeaseKind kind = LeaseKind::kComputing);
  void release();

 private:
  friend class MemoryLedger;

  MemoryLedger* ledger_ = nullptr;
  MemoryOwner owner_;
  std::uint64_t bytes_ = 0;
  LeaseKind kind_ = LeaseKind::kWaiting;
};

/// The memory that a server may use for its clients, and how much of it is leased: payloads as received, decoded
/// clouds, the workspace of segmentation, and results until they are read. Memory is leased before it is allocated.
/// Thread-safe.
///
/// Two rules keep it useful for everybody. Frames that only wait get at most half of the budget, unless one waits
/// alone, so that those that are computed find room. And for some seconds after one was refused, others that hold
/// something get no more than their share. All that hold something or were refused lately have equal shares: addresses
/// of the budget, streams of their address's.
class MemoryLedger {
 public:
  using Time = std::chrono::steady_clock::time_point;

  explicit MemoryLedger(std::uint64_t budget, std::function<Time()> now = std::chrono::steady_clock::now)
      : budget_(budget), now_(std::move(now)) {}

  /// Memory for something that waits for its turn. nullopt if so many bytes are not free for it.
  std::optional<MemoryLease> lease(const MemoryOwner& owner, std::uint64_t bytes);

  /// Whether somebody was refused in the last seconds.
  bool is_short() const;
  std::uint64_t budget() const { return budget_; }
  std::uint64_t leased() const;
  MemoryUse use() const;

 private:
  friend class MemoryLease;

  struct Holding {
    std::uint64_t bytes = 0;
    std::size_t leases = 0;
    Time refused_until{};  // it may come again, so that others must not take more than their share until then
  };
  struct Address {
    Holding total;
    std::map<std::string, Holding> streams = {};
  };

  bool has_room_for(const MemoryOwner& owner, std::uint64_t bytes) const ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);
  void note_refusal(const MemoryOwner& owner, Time now) ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);
  void forget_refusals(Time now) ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);
  /// The holdings of the owner's address and of its stream.
  std::array<Holding*, 2> holdings_of(const MemoryOwner& owner) ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);
  /// A lease of the owner has `after` bytes instead of `before`.
  void change(const MemoryOwner& owner, std::uint64_t before, std::uint64_t after)
      ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);
  bool resize(MemoryLease& lease, std::uint64_t bytes, LeaseKind kind);
  /// The bytes of all leases of this kind.
  std::uint64_t& of(LeaseKind kind) ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_) {
    return by_kind_[static_cast<std::size_t>(kind)];
  }
  bool is_short_at(Time now) const ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);
  void release(const MemoryLease& lease);

  const std::uint64_t budget_;
  const std::function<Time()> now_;
  mutable Mutex mutex_;
  std::uint64_t leased_ ABSL_GUARDED_BY(mutex_) = 0;
  std::array<std::uint64_t, kLeaseKinds> by_kind_ ABSL_GUARDED_BY(mutex_){};  // its parts
  std::uint64_t refusals_ ABSL_GUARDED_BY(mutex_) = 0;
  std::map<std::string, Address> addresses_ ABSL_GUARDED_BY(mutex_);
  Time last_refusal_ ABSL_GUARDED_BY(mutex_){};
};

/// The memory that this process may use, bytes: the least of the limits of its cgroups, and of the machine's memory.
std::uint64_t available_memory();

}  // namespace segserve::server
