// SPDX-License-Identifier: Apache-2.0
#include "server/health/health_watch.hpp"

#include <utility>

#include "absl/status/statusor.h"
#include "server/frames/catch_exceptions.hpp"
#include "server/frames/final_status.hpp"
#include "server/health/health_message.hpp"

namespace segserve::server {

void HealthWatch::start() {
  const std::shared_ptr<HealthWatch> self = shared_from_this();
  const absl::Status admitted = state_.add(self, client_);
  self_ = self;
  if (!admitted.ok()) return finish(admitted);
  on_change();
}

void HealthWatch::on_change() {
  const MutexLock lock(mutex_);
  write_if_changed();
}

void HealthWatch::write_if_changed() {
  if (finished_ || writing_) return;
  const HealthState::Status status = state_.status_of(service_);
  if (last_ == status) return;
  absl::StatusOr<grpc::ByteBuffer> response = catch_exceptions(
      "tell its health", [status]() -> absl::StatusOr<grpc::ByteBuffer> { return health_response(status); });
  if (!response.ok()) return;  // there is no memory for it; the next change is told
  last_ = status;
  writing_ = true;
  response_ = *std::move(response);
  StartWrite(&response_);
}

void HealthWatch::OnWriteDone(bool ok) {
  if (!ok) return finish(absl::CancelledError("the connection broke"));
  const MutexLock lock(mutex_);
  writing_ = false;
  write_if_changed();
}

void HealthWatch::on_close() { finish(absl::UnavailableError("the server stops")); }

void HealthWatch::OnCancel() { finish(absl::CancelledError("the client gave up, or its deadline passed")); }

void HealthWatch::finish(const absl::Status& status) {
  const MutexLock lock(mutex_);
  if (finished_) return;
  finished_ = true;
  Finish(final_status(status));
}

void HealthWatch::OnDone() {
  state_.remove(self_);
  self_.reset();  // `this` may be gone now
}

}  // namespace segserve::server
