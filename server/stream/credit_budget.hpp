// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <optional>

#include "absl/base/thread_annotations.h"
#include "core/base/mutex.hpp"

namespace segserve::server {

/// Frames and bytes of payload that a client may have under way.
struct Credit {
  std::uint32_t frames = 0;
  std::uint64_t bytes = 0;
  bool operator==(const Credit&) const = default;
};

/// How credit is given to streams.
struct CreditLimits {
  Credit most_per_stream;
  std::uint64_t default_bytes_per_stream;  ///< for a stream that asks for nothing
  std::uint64_t bytes_of_all_streams;
};

/// Bounds the payload that all streams together may have under way to this server, before it arrives. Thread-safe.
class CreditBudget {
 public:
  /// Gives its bytes back when it is destroyed. The budget must outlive it.
  class Reservation {
   public:
    Reservation() = default;
    Reservation(CreditBudget& budget, const Credit& credit) : budget_(&budget), credit_(credit) {}
    Reservation(Reservation&& other) noexcept { *this = std::move(other); }
    Reservation& operator=(Reservation&& other) noexcept;
    ~Reservation() { release(); }

    const Credit& credit() const { return credit_; }
    void release();

   private:
    CreditBudget* budget_ = nullptr;
    Credit credit_;
  };

  explicit CreditBudget(const CreditLimits& limits) : limits_(limits), free_bytes_(limits.bytes_of_all_streams) {}

  /// Reserves what is wanted (0: the default) within the limits of a stream. If fewer bytes are free, the reservation
  /// gets those; nullopt if they are less than a 16th of what it should have.
  std::optional<Reservation> reserve(const Credit& wanted);

  std::uint64_t free_bytes() const;

 private:
  const CreditLimits limits_;
  mutable Mutex mutex_;
  std::uint64_t free_bytes_ ABSL_GUARDED_BY(mutex_);
};

}  // namespace segserve::server
