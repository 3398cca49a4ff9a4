// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <map>
#include <memory>
#include <string>
#include <string_view>

#include "absl/base/thread_annotations.h"
#include "absl/status/status.h"
#include "core/base/mutex.hpp"
#include "grpc/health/v1/health.pb.h"

namespace segserve::server {

/// Hears of every change of health. It may be called from any thread.
class HealthObserver {
 public:
  virtual ~HealthObserver() = default;
  virtual void on_change() = 0;
  /// The server closes: there will be no more changes.
  virtual void on_close() = 0;
};

/// The health of a server by the names of grpc.health.v1, for all addresses at which it is asked:
///
/// - "liveness" serves until the server can do no more, so that it must be started anew;
/// - "readiness", "" and the service's own name serve while the server takes calls.
///
/// Thread-safe.
class HealthState {
 public:
  using Status = grpc::health::v1::HealthCheckResponse::ServingStatus;

  /// SERVICE_UNKNOWN for other names.
  Status status_of(std::string_view service) const;

  void set_ready(bool ready);
  void set_alive(bool alive);
  /// Ends all watches, and refuses later ones.
  void close();

  /// RESOURCE_EXHAUSTED if there are too many, in all or of this client (see client_address); UNAVAILABLE if the server
  /// closes. An observer is called until it is removed, and shortly after.
  absl::Status add(const std::shared_ptr<HealthObserver>& observer, const std::string& client);
  void remove(const std::shared_ptr<HealthObserver>& observer);

 private:
  using Observers = std::map<std::shared_ptr<HealthObserver>, std::string>;  // and their clients

  /// They are called without the lock, because they ask for the status and remove themselves.
  Observers observers() const;

  mutable Mutex mutex_;
  bool ready_ ABSL_GUARDED_BY(mutex_) = false;
  bool alive_ ABSL_GUARDED_BY(mutex_) = true;
  bool closed_ ABSL_GUARDED_BY(mutex_) = false;
  Observers observers_ ABSL_GUARDED_BY(mutex_);
};

}  // namespace segserve::server
