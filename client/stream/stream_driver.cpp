#include "client/stream/stream_driver.hpp"

#include <chrono>
#include <random>
#include <utility>
#include <vector>

#include "client/calls/answer.hpp"
#include "client/calls/local.hpp"
#include "fmt/format.h"
#include "segserve/v1/segmentation_service.grpc.pb.h"

namespace segserve::client {
/// A question that any living server answers at once.
struct StreamDriver::Probe {
  explicit Probe(const std::shared_ptr<grpc::Channel>& channel) : stub(channel) {}
  v1::SegmentationService::Stub stub;
  grpc::ClientContext context;
  v1::GetServerInfoRequest request;
  v1::GetServerInfoResponse response;
};

StreamDriver::StreamDriver(std::shared_ptr<Channels> channels, StreamOptions options)
    : channels_(std::move(channels)),
      options_(std::move(options)),
      core_(options_, channels_->addresses(), channels_->next_start(), std::random_device()()) {}

void StreamDriver::start() {
  thread_ = std::thread([this] { drive(); });
  if (options_.on_outcome) callback_thread_ = std::thread([this] { call_back(); });
  if (options_.fallback_to_local) local_thread_ = std::thread([this] { segment_locally(); });
}

void StreamDriver::stop() {
  {
    const std::lock_guard lock(mutex_);
    stopping_ = true;
    stop_local_ = true;
    core_.close(Clock::now());
    changed();
  }
  if (thread_.joinable()) thread_.join();
  if (callback_thread_.joinable()) callback_thread_.join();
  if (local_thread_.joinable()) local_thread_.join();
}

void StreamDriver::changed() {
  ++changes_;
  changed_.notify_all();
}

absl::StatusOr<std::uint64_t> StreamDriver::send(Payload payload, FrameOptions options) {
  std::unique_lock lock(mutex_);
  const Time handed_over = Clock::now();
  if (!options.captured) options.captured = handed_over;
  const Time deadline = handed_over + options.timeout.value_or(options_.frame_timeout);
  const auto may_enter = [&] { return core_.admission() != StreamCore::Admission::kWait; };
  if (!changed_.wait_until(lock, deadline, may_enter)) {
    return absl::DeadlineExceededError(
        fmt::format("{} frames wait already, and nobody made room for one more in time", options_.max_waiting));
  }
  if (core_.admission() == StreamCore::Admission::kRefused) {
    if (!core_.fatal().ok()) return core_.fatal();
    if (options_.when_behind == WhenBehind::kReject && !stopping_ && !core_.exhausted()) {
      return absl::ResourceExhaustedError(fmt::format("{} frames wait already", options_.max_waiting));
    }
    return absl::FailedPreconditionError("the stream takes no more frames: finish() was called");
  }
  const std::uint64_t sequence = core_.accept(std::move(payload), std::move(options), Clock::now());
  changed();
  lock.unlock();
  pump();
  return sequence;
}

void StreamDriver::cancel(std::uint64_t sequence) {
  {
    const std::lock_guard lock(mutex_);
    core_.cancel(sequence, Clock::now());
    changed();
  }
  pump();
}

void StreamDriver::finish() {
  const std::lock_guard lock(mutex_);
  core_.finish_sending();
  changed();
}

std::optional<RawOutcome> StreamDriver::next(std::optional<Time> until) {
  std::unique_lock lock(mutex_);
  const auto ready = [&] { return (core_.has_outcome() && !options_.on_outcome) || all_taken(); };
  if (!until) {
    changed_.wait(lock, ready);
  } else if (!changed_.wait_until(lock, *until, ready)) {
    return std::nullopt;
  }
  if (options_.on_outcome) return std::nullopt;
  auto raw = core_.take_outcome();
  changed();  // there may be room for another frame now
  lock.unlock();
  pump();
  return raw;
}

bool StreamDriver::exhausted() {
  const std::lock_guard lock(mutex_);
  return all_taken();
}

bool StreamDriver::next_message(std::uint64_t call, Outgoing& outgoing) {
  const std::lock_guard lock(mutex_);
  const bool is_header_due = core_.next_message(call, outgoing, Clock::now());
  if (is_header_due && outgoing.message.has_frame()) changed();  // one frame waits less
  return is_header_due;
}

bool StreamDriver::wants_half_close(std::uint64_t call) {
  const std::lock_guard lock(mutex_);
  return core_.wants_half_close(call);
}

void StreamDriver::on_written(std::uint64_t call) {
  const std::lock_guard lock(mutex_);
  core_.on_sign_of_life(call, Clock::now());
}

void StreamDriver::on_message(std::uint64_t call, v1::SegmentStreamResponse& message) {
  const std::lock_guard lock(mutex_);
  if (core_.on_message(call, message, Clock::now())) changed();
}

void StreamDriver::on_closed(std::uint64_t call, const absl::Status& status) {
  const std::lock_guard lock(mutex_);
  core_.on_closed(call, status, Clock::now());
  ended_.push_back(std::move(calls_.extract(call).mapped()));
  changed();
}

void StreamDriver::pump() {
  std::vector<std::shared_ptr<StreamCall>> calls;
  {
    const std::lock_guard lock(mutex_);
    for (const auto& [id, call] : calls_) calls.push_back(call);
  }
  for (const auto& call : calls) call->pump();
}

void StreamDriver::drive() {
  std::unique_lock lock(mutex_);
  while (true) {
    const std::uint64_t seen = changes_;
    StreamCore::Tick tick = core_.tick(Clock::now());
    const bool over = stopping_ && calls_.empty() && probes_.empty() && tick.actions.empty();
    std::vector<std::shared_ptr<void>> ended = std::exchange(ended_, {});
    lock.unlock();
    ended.clear();
    if (over) return;
    for (const StreamCore::Action& action : tick.actions) perform(action);
    pump();
    lock.lock();
    // What the core did in tick() concerns those who wait for outcomes or for room, too.
    changed_.notify_all();
    changed_.wait_until(lock, tick.wake_at, [&] { return changes_ != seen; });
  }
}

void StreamDriver::call_back() {
  std::unique_lock lock(mutex_);
  while (true) {
    changed_.wait(lock, [this] { return core_.has_outcome() || core_.exhausted(); });
    auto raw = core_.take_outcome();
    if (!raw) return;
    calling_back_ = true;
    changed();  // there may be room for another frame now
    lock.unlock();
    pump();
    options_.on_outcome(finished(*std::move(raw)));
    lock.lock();
    calling_back_ = false;
    changed();
  }
}

void StreamDriver::perform(const StreamCore::Action& action) {
  if (action.kind == StreamCore::Action::kOpen) return open(action);
  if (action.kind == StreamCore::Action::kProbe) return probe(action);
  std::shared_ptr<StreamCall> call;
  {
    const std::lock_guard lock(mutex_);
    const auto found = calls_.find(action.connection);
    if (found == calls_.end()) return;
    call = found->second;
  }
  if (action.kind == StreamCore::Action::kBreakSilent) channels_->renew(action.address, call->channel());
  call->cancel();
}

void StreamDriver::open(const StreamCore::Action& action) {
  auto call = std::make_shared<StreamCall>(action.connection, channels_->addresses()[action.address],
                                           channels_->get(action.address), *this);
  {
    const std::lock_guard lock(mutex_);
    calls_[action.connection] = call;
  }
  call->start();
}

void StreamDriver::probe(const StreamCore::Action& action) {
  std::shared_ptr<Probe> probe;
  {
    const std::lock_guard lock(mutex_);
    const auto call = calls_.find(action.connection);
    if (call == calls_.end() || probes_.contains(action.connection)) return;
    probe = probes_[action.connection] = std::make_shared<Probe>(call->second->channel());
  }
  probe->context.set_deadline(std::chrono::system_clock::now() + options_.progress_timeout / 2);
  auto done = [this, id = action.connection](const grpc::Status& status) { on_probed(id, status.ok()); };
  probe->stub.async()->GetServerInfo(&probe->context, &probe->request, &probe->response, std::move(done));
}

void StreamDriver::on_probed(std::uint64_t call, bool alive) {
  const std::lock_guard lock(mutex_);
  if (alive) core_.on_sign_of_life(call, Clock::now());
  ended_.push_back(std::move(probes_.extract(call).mapped()));
  changed();
}

void StreamDriver::segment_locally() {
  std::unique_lock lock(mutex_);
  while (!stopping_) {
    std::optional<StreamCore::LocalJob> job = core_.take_local_job(Clock::now());
    if (!job) {
      // Frames become ready as time passes, and the driver's thread tells.
      changed_.wait(lock);
      continue;
    }
    lock.unlock();
    auto result = segment_here(job->payload, job->options, job->outputs, StopToken(&stop_local_, job->deadline));
    lock.lock();
    core_.on_local_result(job->sequence, std::move(result), Clock::now());
    changed();
  }
}

Outcome finished(RawOutcome raw) {
  Outcome& outcome = raw.outcome;
  if (outcome.kind != OutcomeKind::kResult || outcome.result) return std::move(outcome);
  const Time start = Clock::now();
  const std::size_t points = raw.payload.points() != 0 ? raw.payload.points() : raw.message.summary().points();
  auto result = check_answer(wire::from_message(raw.message, points), raw.outputs);
  outcome.report.decode_ms = std::chrono::duration<double, std::milli>(Clock::now() - start).count();
  if (result.ok()) {
    outcome.result = *std::move(result);
  } else {
    outcome.kind = OutcomeKind::kFailed;
    outcome.status = result.status();
  }
  return std::move(outcome);
}

}  // namespace segserve::client
