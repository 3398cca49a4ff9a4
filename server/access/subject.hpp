// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>
#include <cstdint>
#include <memory>
#include <string>
#include <string_view>

#include "absl/base/thread_annotations.h"
#include "absl/status/statusor.h"
#include "core/base/mutex.hpp"
#include "credentials/subject_limits.hpp"
#include "server/access/rate_bucket.hpp"

namespace segserve::server {

class Subject;

/// The share of its subject's limits that one frame takes. The bytes in flight return when it is destroyed; frames and
/// points do not. One thread at a time may use it. A default one takes nothing.
class QuotaLease {
 public:
  QuotaLease() = default;
  QuotaLease(std::shared_ptr<Subject> subject, std::uint64_t points, std::uint64_t bytes)
      : subject_(std::move(subject)), points_(points), bytes_(bytes) {}
  QuotaLease(QuotaLease&& other) noexcept { *this = std::move(other); }
  QuotaLease& operator=(QuotaLease&& other) noexcept;
  ~QuotaLease() { release(); }

  /// The frame turned out to have so many points.
  void settle(std::uint64_t points);
  /// The server could not take the frame: it counts against nothing.
  void refund();

 private:
  void release();

  std::shared_ptr<Subject> subject_;  // null: nothing is taken
  std::uint64_t points_ = 0;
  std::uint64_t bytes_ = 0;
};

/// Somebody who makes calls, on any number of connections: the owner of a token, or who a JWT or a certificate names.
/// It has limits, and knows what it has used of them. Thread-safe.
class Subject : public std::enable_shared_from_this<Subject> {
 public:
  using Time = RateBucket::Time;

  Subject(std::string name, const credentials::SubjectLimits& limits, Time now);

  const std::string& name() const { return name_; }
  void set_limits(const credentials::SubjectLimits& limits, Time now);
  credentials::SubjectLimits limits() const;

  /// Takes a frame of so many points (an estimate) and bytes of payload. RESOURCE_EXHAUSTED with QUOTA_EXCEEDED, the
  /// name of the limit and a delay if the frame has to wait; with LIMIT_EXCEEDED if it has more bytes than may ever be
  /// in flight. Nothing is taken then.
  absl::StatusOr<QuotaLease> admit(std::uint64_t points, std::uint64_t bytes, Time now);

  /// Whether there is nothing to remember: no bytes are in flight, and the rates were not used in the last second.
  bool is_at_rest(Time now);

 private:
  friend class QuotaLease;

  void release_bytes(std::uint64_t bytes);
  void take_points(double points);
  void give_back(double frames, double points);

  const std::string name_;
  mutable Mutex mutex_;
  credentials::SubjectLimits limits_ ABSL_GUARDED_BY(mutex_);
  RateBucket frames_ ABSL_GUARDED_BY(mutex_);
  RateBucket points_ ABSL_GUARDED_BY(mutex_);
  std::uint64_t bytes_in_flight_ ABSL_GUARDED_BY(mutex_) = 0;
};

}  // namespace segserve::server
