// SPDX-License-Identifier: Apache-2.0
#include "server/stream/session_transport.hpp"

#include "absl/status/status.h"
#include "grpcpp/impl/codegen/proto_utils.h"
#include "proto/wire/message_shape.hpp"
#include "proto/wire/status_message.hpp"
#include "segserve/v1/stream.pb.h"
#include "server/frames/catch_exceptions.hpp"
#include "server/frames/final_status.hpp"

namespace segserve::server {

void SessionTransport::prepare(const StreamSettings& settings, MemoryOwner owner, Caller caller, AccessGrant grant) {
  settings_ = &settings;
  auto wake = [weak = weak_from_this()] {
    if (const auto self = weak.lock()) self->advance();
  };
  session_ = std::make_shared<StreamSession>(settings, std::move(owner), std::move(caller), *executor_, std::move(wake),
                                             std::move(grant));
  registry_.add(session_);
}

void SessionTransport::start() noexcept {
  self_ = shared_from_this();
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
  v1::SegmentStreamRequest message;
  const absl::Status parsed = catch_exceptions(
      "read a message", [&] { return wire::parse_bounded(request_, "SegmentStreamRequest", message); });
  if (parsed.ok()) {
    session_->on_message(message);
  } else {
    session_->on_broken_message(parsed);
  }
  read();
}

absl::StatusOr<bool> SessionTransport::next_response() {
  v1::SegmentStreamResponse message;
  if (!session_->next(message)) return false;
  response_.Clear();
  bool owns_buffer = false;
  const grpc::Status status =
      grpc::SerializationTraits<v1::SegmentStreamResponse>::Serialize(message, &response_, &owns_buffer);
  if (!status.ok()) return absl::InternalError("a message of the stream cannot be serialized");
  return true;
}

void SessionTransport::advance() {
  bool is_unread = false;
  {
    const MutexLock lock(mutex_);
    if (finished_) return;
    if (writing_) {
      is_unread = StreamSettings::Clock::now() - write_began_ >= settings_->result_timeout_now();
    } else {
      const absl::StatusOr<bool> has_next = catch_exceptions("write a message", [&] { return next_response(); });
      if (!has_next.ok()) session_->end(has_next.status());
      if (has_next.ok() && *has_next) {
        writing_ = true;
        write_began_ = StreamSettings::Clock::now();
        StartWrite(&response_);
      } else if (const auto status = session_->ended()) {
        finished_ = true;
        settings_->observers.on_stream(session_->record(*status));
        Finish(final_status(*status));
      }
    }
  }
  if (is_unread) canceler_.cancel();
}

void SessionTransport::OnWriteDone(bool ok) {
  {
    const MutexLock lock(mutex_);
    writing_ = false;
  }
  if (ok) {
    advance();
  } else {
    end_call("the connection broke");
  }
}

void SessionTransport::OnCancel() { end_call("the client gave up, or its deadline passed"); }

void SessionTransport::end_call(const char* why) {
  // It wakes this object, which finishes the call.
  session_->on_cancel(catch_exceptions("tell why the stream ends", [why] { return absl::CancelledError(why); }));
}

void SessionTransport::OnDone() {
  canceler_.forget();
  registry_.remove(session_);
  InFlightCalls& calls = calls_;
  self_.reset();    // `this` may be gone now
  calls.release();  // comes last, because the service may end as soon as no call is in flight
}

}  // namespace segserve::server
