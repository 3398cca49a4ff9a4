// SPDX-License-Identifier: Apache-2.0
#include "server/stream/stream_session.hpp"

#include <utility>

#include "absl/status/statusor.h"
#include "core/base/status_macros.hpp"
#include "core/base/status_text.hpp"
#include "fmt/format.h"
#include "proto/wire/payload_blocks.hpp"
#include "proto/wire/status_message.hpp"
#include "server/frames/catch_exceptions.hpp"
#include "server/frames/frame_computation.hpp"
#include "server/scheduling/refusals.hpp"
#include "server/stream/protocol_violation.hpp"

namespace segserve::server {
namespace {

absl::Status unfinished_upload(const StreamFrame& frame) {
  return wire::malformed(fmt::format("the stream was closed with {} of {} bytes of the frame missing",
                                     frame.payload.missing(), frame.header.encoded_bytes()));
}

absl::Status stalled() {
  return wire::with_reason(absl::DeadlineExceededError("the chunks of the frame came too slowly, or not at all"),
                           wire::ErrorReason::kUploadStalled);
}

absl::Status idle(std::chrono::milliseconds timeout) {
  return absl::UnavailableError(fmt::format("the stream had neither a message nor a frame for {} s",
                                            std::chrono::duration_cast<std::chrono::seconds>(timeout).count()));
}

/// The outcome of a frame whose turn it is.
absl::StatusOr<FinishedFrame> compute_outcome(StreamFrame& frame, SegmentationBackend& backend) {
  ASSIGN_OR_RETURN(v1::SegmentationResult result,
                   compute_frame(frame.header.cloud(), frame.settings, frame.cancelled, backend, frame.memory));
  FinishedFrame finished = outcome_with_result(frame, std::move(result));
  finished.memory = std::move(frame.memory);
  return finished;
}

}  // namespace

StreamSession::StreamSession(const StreamSettings& settings, MemoryOwner owner, FrameExecutor& executor,
                             std::function<void()> wake)
    : settings_(settings),
      owner_(std::move(owner)),
      wake_(std::move(wake)),
      protocol_(settings.greeting, outbox_),
      scheduler_(executor, outbox_),
      last_message_(settings.now()) {}

template <typename Function>
void StreamSession::change(Function&& function) {
  {
    const MutexLock lock(mutex_);
    const absl::Status status = catch_exceptions("process a message of the stream", function);
    if (!status.ok()) end_with(status);
  }
  wake_();
}

void StreamSession::on_message(v1::SegmentStreamRequest& message) {
  change([&]() -> absl::Status {
    mutex_.assert_held();
    if (end_) return absl::OkStatus();
    last_message_ = settings_.now();
    return handle(message);
  });
}

void StreamSession::on_broken_message(const absl::Status& why) {
  change([&] { return protocol_violation(message_of(why)); });
}

void StreamSession::end(const absl::Status& status) {
  const MutexLock lock(mutex_);
  end_with(status);
}

void StreamSession::on_half_close() {
  change([&] {
    mutex_.assert_held();
    if (const StreamFramePointer frame = protocol_.half_close()) scheduler_.fail(frame, unfinished_upload(*frame));
    return absl::OkStatus();
  });
}

void StreamSession::on_cancel(const absl::Status& why) {
  change([&] { return why; });
}

void StreamSession::start_draining() {
  change([&] {
    mutex_.assert_held();
    draining_ = true;
    protocol_.announce_draining();
    return absl::OkStatus();
  });
}

void StreamSession::on_tick() {
  change([&]() -> absl::Status {
    mutex_.assert_held();
    const StreamFrame::Time now = settings_.now();
    scheduler_.expire(now);
    const StreamFramePointer slow = protocol_.stalled_upload(now, settings_.upload_pace_now());
    if (slow) scheduler_.fail(slow, stalled());
    if (scheduler_.in_flight() > 0 || !outbox_.empty()) last_message_ = now;
    if (now - last_message_ >= settings_.idle_timeout) return idle(settings_.idle_timeout);
    return absl::OkStatus();
  });
}

absl::Status StreamSession::handle(v1::SegmentStreamRequest& message) {
  using Event = SessionProtocol::Event;
  ASSIGN_OR_RETURN(const Event event, protocol_.receive(message, settings_.now()));
  switch (event.kind) {
    case Event::kOpen:
      return open(message.open());
    case Event::kBegun:
      begin(event.frame);
      break;
    case Event::kUploaded:
      enqueue(event.frame);
      break;
    case Event::kCancel:
      scheduler_.cancel(event.sequence);
      break;
    case Event::kNothing:
      break;
  }
  return absl::OkStatus();
}

absl::Status StreamSession::open(const v1::StreamOpen& message) {
  ASSIGN_OR_RETURN(defaults_, settings_.resolver.resolve_stream(message));
  if (draining_) return draining();
  scheduler_.set_policy(message);
  protocol_.grant(settings_.credit.grant({message.wanted().frames(), message.wanted().bytes()}));
  return absl::OkStatus();
}

void StreamSession::begin(const StreamFramePointer& frame) {
  scheduler_.add(frame);
  if (const absl::Status status = draining_ ? draining() : resolve(*frame); !status.ok()) {
    scheduler_.fail(frame, status);
  } else if (frame->payload.missing() == 0) {
    enqueue(frame);
  }
}

absl::Status StreamSession::resolve(StreamFrame& frame) {
  ASSIGN_OR_RETURN(frame.settings, settings_.resolver.resolve_frame(frame.header, defaults_, settings_.now()));
  if (settings_.ledger != nullptr) frame.memory = FrameMemory(*settings_.ledger, owner_, settings_.max_voxels);
  RETURN_IF_ERROR(frame.memory.receive(frame.header.encoded_bytes()));
  frame.payload = wire::IncomingBytes(wire::payload_block_sizes(frame.header.cloud()));
  return absl::OkStatus();
}

void StreamSession::enqueue(const StreamFramePointer& frame) {
  if (const absl::Status status = attach_payload(*frame); !status.ok()) return scheduler_.fail(frame, status);
  scheduler_.submit(
      frame, [self = shared_from_this(), frame](SegmentationBackend& backend) { self->compute(frame, backend); });
}

void StreamSession::compute(const StreamFramePointer& frame, SegmentationBackend& backend) {
  bool starts = false;
  change([&] {
    mutex_.assert_held();
    starts = scheduler_.start(frame, settings_.now());
    return absl::OkStatus();
  });
  if (!starts) return;
  absl::StatusOr<FinishedFrame> computed =
      catch_exceptions("process this frame", [&] { return compute_outcome(*frame, backend); });
  change([&] {
    mutex_.assert_held();
    scheduler_.complete(frame, std::move(computed), settings_.now());
    return absl::OkStatus();
  });
}

void StreamSession::end_with(const absl::Status& status) {
  if (end_) return;
  end_ = status;
  scheduler_.abandon_all();
  protocol_.forget_upload();
  outbox_.clear();
}

bool StreamSession::next(v1::SegmentStreamResponse& message) {
  const MutexLock lock(mutex_);
  return !end_ && protocol_.next(message);
}

std::optional<absl::Status> StreamSession::ended() const {
  const MutexLock lock(mutex_);
  if (scheduler_.running() > 0) return std::nullopt;
  if (end_) return end_;
  if (scheduler_.in_flight() > 0 || !protocol_.all_sent()) return std::nullopt;
  if (protocol_.half_closed()) return absl::OkStatus();
  if (draining_) return draining();
  return std::nullopt;
}

std::size_t StreamSession::frames_in_flight() const {
  const MutexLock lock(mutex_);
  return scheduler_.in_flight();
}

}  // namespace segserve::server
