// SPDX-License-Identifier: Apache-2.0
#include "server/stream/session_transport.hpp"

#include "absl/status/status.h"
#include "proto/wire/status_message.hpp"

namespace segserve::server {

void SessionTransport::start(const StreamSettings& settings, CreditBudget& budget) {
  self_ = shared_from_this();
  session_ = std::make_shared<StreamSession>(settings, *executor_, budget, [weak = weak_from_this()] {
    if (const auto self = weak.lock()) self->advance();
  });
  registry_.add(session_);
  read();
}

void SessionTransport::read() {
  const MutexLock lock(mutex_);
  if (!finished_) StartRead(&request_);
}

void SessionTransport::OnReadDone(bool ok) {
  if (!ok) {
    session_->on_half_close();
    return;
  }
  session_->on_message(request_);
  read();
}

void SessionTransport::advance() {
  const MutexLock lock(mutex_);
  if (writing_ || finished_) return;
  if (session_->next(response_)) {
    writing_ = true;
    StartWrite(&response_);
  } else if (const auto status = session_->ended()) {
    finished_ = true;
    Finish(wire::to_grpc(*status));
  }
}

void SessionTransport::OnWriteDone(bool ok) {
  {
    const MutexLock lock(mutex_);
    writing_ = false;
  }
  if (ok) {
    advance();
  } else {
    session_->on_cancel(absl::CancelledError("the connection broke"));  // wakes this object, which advances
  }
}

void SessionTransport::OnCancel() {
  session_->on_cancel(absl::CancelledError("the client gave up, or its deadline passed"));
}

void SessionTransport::OnDone() {
  registry_.remove(session_);
  session_->close();
  InFlightCalls& calls = calls_;
  self_.reset();    // `this` may be gone now
  calls.release();  // comes last, because the service may end as soon as no call is in flight
}

}  // namespace segserve::server
