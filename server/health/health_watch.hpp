// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <utility>

#include "absl/base/thread_annotations.h"
#include "absl/status/status.h"
#include "core/base/mutex.hpp"
#include "grpcpp/support/byte_buffer.h"
#include "grpcpp/support/server_callback.h"
#include "server/health/health_state.hpp"

namespace segserve::server {

/// One call of Watch: writes the status of a service, and again whenever it has changed. A client that does not read
/// gets the newest status once it does. The object owns itself from `start` to OnDone.
class HealthWatch final : public grpc::ServerWriteReactor<grpc::ByteBuffer>,
                          public HealthObserver,
                          public std::enable_shared_from_this<HealthWatch> {
 public:
  /// `state` must outlive the call.
  HealthWatch(HealthState& state, std::string service, std::string client)
      : state_(state), service_(std::move(service)), client_(std::move(client)) {}

  /// Ends the call at once if HealthState takes no more observers.
  void start();

  void on_change() override;
  void on_close() override;
  void OnWriteDone(bool ok) override;
  void OnCancel() override;
  void OnDone() override;

 private:
  void write_if_changed() ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);
  void finish(const absl::Status& status);

  HealthState& state_;
  const std::string service_;
  const std::string client_;
  std::shared_ptr<HealthWatch> self_;
  grpc::ByteBuffer response_;  // gRPC's while a write is under way
  Mutex mutex_;
  std::optional<HealthState::Status> last_ ABSL_GUARDED_BY(mutex_);  // that was written
  bool writing_ ABSL_GUARDED_BY(mutex_) = false;
  bool finished_ ABSL_GUARDED_BY(mutex_) = false;
};

}  // namespace segserve::server
