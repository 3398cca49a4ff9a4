// SPDX-License-Identifier: Apache-2.0
#include "server/stream/stream_session.hpp"

#include <algorithm>
#include <chrono>
#include <random>
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

// A token that has expired, or was withdrawn, is noticed within this time even if no frame comes.
constexpr std::chrono::seconds kBetweenProofs{1};

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

/// When a stream that begins now is old.
StreamFrame::Time end_of_youth(const StreamSettings& settings) {
  if (settings.max_age == std::chrono::milliseconds(0)) return StreamFrame::Time::max();
  thread_local std::minstd_rand random(std::random_device{}());
  const double factor = std::uniform_real_distribution<double>(0.9, 1.1)(random);
  return settings.now() + std::chrono::duration_cast<StreamFrame::Time::duration>(settings.max_age * factor);
}

/// The outcome of a frame whose turn it is.
absl::StatusOr<FinishedFrame> compute_outcome(StreamFrame& frame, SegmentationBackend& backend) {
  ASSIGN_OR_RETURN(v1::SegmentationResult result, compute_frame(frame.header.cloud(), frame.settings, frame.cancelled,
                                                                backend, frame.memory, frame.record.work));
  frame.quota.settle(result.summary().points());
  FinishedFrame finished = outcome_with_result(frame, std::move(result));
  finished.memory = std::move(frame.memory);
  return finished;
}

}  // namespace

StreamSession::StreamSession(const StreamSettings& settings, MemoryOwner owner, Caller caller, FrameExecutor& executor,
                             std::function<void()> wake, AccessGrant grant)
    : settings_(settings),
      owner_(std::move(owner)),
      wake_(std::move(wake)),
      protocol_(settings.greeting, outbox_),
      scheduler_(executor, outbox_, settings.observers),
      caller_(std::make_shared<const Caller>(std::move(caller))),
      began_(settings.now()),
      grant_(std::move(grant)),
      proof_checked_(began_),
      last_message_(began_) {}

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
    protocol_.half_close(settings_.now());
    return absl::OkStatus();
  });
}

void StreamSession::on_cancel(const absl::Status& why) {
  change([&] { return why; });
}

void StreamSession::start_draining() {
  change([&] {
    mutex_.assert_held();
    close_with(draining(), v1::DRAIN_REASON_UNSPECIFIED);
    return absl::OkStatus();
  });
}

void StreamSession::on_tick() {
  change([&]() -> absl::Status {
    mutex_.assert_held();
    const StreamFrame::Time now = settings_.now();
    if (now - proof_checked_ >= kBetweenProofs) {
      proof_checked_ = now;
      close_with(grant_.check(), v1::DRAIN_REASON_TOKEN);
    }
    scheduler_.expire(now);
    look_at_age(now);
    const StreamFramePointer cut_off = protocol_.cut_off_upload(now);
    if (cut_off) scheduler_.fail(cut_off, unfinished_upload(*cut_off), now);
    const StreamFramePointer slow = protocol_.stalled_upload(now, settings_.upload_pace_now());
    if (slow) scheduler_.fail(slow, stalled(), now);
    if (scheduler_.in_flight() > 0 || !outbox_.empty()) last_message_ = now;
    if (now - last_message_ >= settings_.idle_timeout) return idle(settings_.idle_timeout);
    return absl::OkStatus();
  });
}

void StreamSession::look_at_age(StreamFrame::Time now) {
  if (now < old_at_ || !closing_.ok()) return;
  if (!told_age_) protocol_.announce_draining(v1::DRAIN_REASON_STREAM_AGE);
  told_age_ = true;
  if (now - old_at_ >= settings_.age_grace) closing_ = draining();
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
      scheduler_.cancel(event.sequence, settings_.now());
      break;
    case Event::kNothing:
      break;
  }
  return absl::OkStatus();
}

absl::Status StreamSession::open(const v1::StreamOpen& message) {
  ASSIGN_OR_RETURN(defaults_, settings_.resolver.resolve_stream(message));
  RETURN_IF_ERROR(closing_);
  Caller caller = *caller_;
  caller.client_name = message.client_name();
  caller_ = std::make_shared<const Caller>(std::move(caller));
  old_at_ = end_of_youth(settings_);
  scheduler_.set_policy(message);
  Credit credit = settings_.credit.grant({message.wanted().frames(), message.wanted().bytes()});
  credit.bytes = std::min(credit.bytes, grant_.most_bytes());
  protocol_.grant(credit);
  return absl::OkStatus();
}

void StreamSession::begin(const StreamFramePointer& frame) {
  frames_ += 1;
  frame->record.caller = caller_;
  frame->record.traceparent = frame->header.traceparent().empty() ? caller_->traceparent : frame->header.traceparent();
  scheduler_.add(frame);
  if (const absl::Status status = admit(*frame); !status.ok()) {
    scheduler_.fail(frame, status, settings_.now());
  } else if (frame->payload.missing() == 0) {
    enqueue(frame);
  }
}

absl::Status StreamSession::admit(StreamFrame& frame) {
  close_with(grant_.check(), v1::DRAIN_REASON_TOKEN);
  RETURN_IF_ERROR(closing_);
  ASSIGN_OR_RETURN(frame.settings, settings_.resolver.resolve_frame(frame.header, defaults_, settings_.now()));
  frame.header.set_priority(grant_.priority(frame.header.priority()));
  ASSIGN_OR_RETURN(frame.quota, grant_.admit(frame.settings.estimated_points, frame.header.encoded_bytes()));
  if (settings_.ledger != nullptr) frame.memory = FrameMemory(*settings_.ledger, owner_, settings_.max_voxels);
  // The state of tracks is in the header and in the settings.
  const std::uint64_t state_bytes = 2 * frame.header.tracking().state().size();
  RETURN_IF_ERROR(frame.memory.receive(frame.header.encoded_bytes() + state_bytes));
  frame.payload = wire::IncomingBytes(wire::payload_block_sizes(frame.header.cloud()));
  return absl::OkStatus();
}

void StreamSession::enqueue(const StreamFramePointer& frame) {
  frame->record.uploaded = settings_.now();
  const absl::Status status = attach_payload(*frame);
  if (!status.ok()) return scheduler_.fail(frame, status, settings_.now());
  scheduler_.submit(
      frame, [self = shared_from_this(), frame](SegmentationBackend& backend) { self->compute(frame, backend); },
      settings_.now());
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

void StreamSession::close_with(const absl::Status& why, v1::DrainReason reason) {
  if (why.ok() || !closing_.ok()) return;
  closing_ = why;
  protocol_.announce_draining(reason);
}

void StreamSession::end_with(const absl::Status& status) {
  if (end_) return;
  end_ = status;
  const StreamFrame::Time now = settings_.now();
  outbox_.abandon_all(status, now, settings_.observers);
  scheduler_.abandon_all(status, now);
  protocol_.forget_upload();
}

bool StreamSession::next(v1::SegmentStreamResponse& message) {
  const MutexLock lock(mutex_);
  std::optional<FinishedFrame> sent;
  if (end_ || !protocol_.next(message, sent)) return false;
  if (sent) {
    sent->record.delivered = settings_.now();
    settings_.observers.on_frame(sent->record);
  }
  return true;
}

std::optional<absl::Status> StreamSession::ended() const {
  const MutexLock lock(mutex_);
  if (scheduler_.running() > 0) return std::nullopt;
  if (end_) return end_;
  if (scheduler_.in_flight() > 0 || !protocol_.all_sent()) return std::nullopt;
  if (protocol_.half_closed()) return absl::OkStatus();
  if (!closing_.ok()) return closing_;
  return std::nullopt;
}

StreamRecord StreamSession::record(const absl::Status& end) const {
  const MutexLock lock(mutex_);
  return {.caller = caller_,
          .began = began_,
          .ended = settings_.now(),
          .is_opened = protocol_.is_open(),
          .frames = frames_,
          .status = facts_of(end)};
}

std::size_t StreamSession::frames_in_flight() const {
  const MutexLock lock(mutex_);
  return scheduler_.in_flight();
}

}  // namespace segserve::server
