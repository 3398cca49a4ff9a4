// SPDX-License-Identifier: Apache-2.0
#include "client/stream/stream_threads.hpp"

#include <algorithm>
#include <random>
#include <system_error>
#include <utility>

#include "client/calls/local.hpp"
#include "client/tls/handshake_fault.hpp"
#include "fmt/format.h"

namespace segserve::client {

StreamThreads::StreamThreads(std::shared_ptr<Channels> channels, StreamOptions options)
    : channels_(std::move(channels)), options_(std::move(options)), scheduler_(options_, std::random_device()()) {}

void StreamThreads::start() {
  subscription_ = channels_->fleet().subscribe([this] { on_servers_changed(); });
  timer_thread_ = std::thread([this] { keep_time(); });
  if (options_.on_outcome) callback_thread_ = std::thread([this] { call_back(); });
  if (options_.fallback_to_local) local_thread_ = std::thread([this] { segment_locally(); });
}

void StreamThreads::stop() {
  channels_->fleet().unsubscribe(subscription_);
  {
    const MutexLock lock(mutex_);
    stopping_ = true;
    stop_local_ = true;
    scheduler_.close(Clock::now());
    for (const auto& [id, probe] : probes_) probe->cancel();
    notify();
  }
  for (std::thread* thread : {&timer_thread_, &callback_thread_, &local_thread_}) {
    if (thread->joinable()) thread->join();
  }
}

void StreamThreads::notify() {
  ++changes_;
  changed_.notify_all();
}

bool StreamThreads::wait(std::optional<Time> until) {
  if (until) return changed_.wait_until(mutex_, *until);
  changed_.wait(mutex_);
  return true;
}

absl::StatusOr<std::uint64_t> StreamThreads::send(Payload payload, FrameOptions options) {
  using Admission = StreamScheduler::Admission;
  const Time handed_over = Clock::now();
  FrameRequest request = resolve(std::move(payload), std::move(options), options_, handed_over);
  const Time until = handed_over + request.timeout;
  std::uint64_t sequence = 0;
  {
    const MutexLock lock(mutex_);
    while (scheduler_.admission() == Admission::kWait) {
      if (!wait(until) && scheduler_.admission() == Admission::kWait) {
        return absl::DeadlineExceededError(
            fmt::format("{} frames wait already, and none of them was sent in time", options_.max_waiting));
      }
    }
    if (scheduler_.admission() == Admission::kRefused) return scheduler_.refusal();
    sequence = scheduler_.accept(std::move(request), Clock::now());
    notify();
  }
  pump();
  return sequence;
}

void StreamThreads::cancel(std::uint64_t sequence) {
  {
    const MutexLock lock(mutex_);
    scheduler_.cancel(sequence, Clock::now());
    notify();
  }
  pump();
}

void StreamThreads::finish() {
  const MutexLock lock(mutex_);
  scheduler_.finish_sending();
  notify();
}

std::optional<Outcome> StreamThreads::next(std::optional<Time> until) {
  std::optional<UndecodedOutcome> undecoded;
  {
    const MutexLock lock(mutex_);
    if (options_.on_outcome) {
      while (!all_taken() && wait(until)) {
      }
      return std::nullopt;
    }
    undecoded = wait_for_outcome(until);
  }
  if (!undecoded) return std::nullopt;
  pump();
  return decode(*std::move(undecoded));
}

std::optional<UndecodedOutcome> StreamThreads::wait_for_outcome(std::optional<Time> until) {
  while (!scheduler_.has_outcome() && !scheduler_.exhausted()) {
    if (!wait(until) && !scheduler_.has_outcome()) return std::nullopt;
  }
  std::optional<UndecodedOutcome> undecoded = scheduler_.take_outcome();
  notify();  // there may be room for another frame, and this may have been the last outcome
  return undecoded;
}

bool StreamThreads::done() {
  const MutexLock lock(mutex_);
  return all_taken();
}

/// The callback thread.
void StreamThreads::call_back() {
  while (true) {
    std::optional<UndecodedOutcome> undecoded;
    {
      const MutexLock lock(mutex_);
      calling_back_ = false;
      undecoded = wait_for_outcome(std::nullopt);
      if (!undecoded) return;
      calling_back_ = true;
    }
    pump();
    options_.on_outcome(decode(*std::move(undecoded)));
  }
}

/// The local thread.
void StreamThreads::segment_locally() {
  while (const auto job = wait_for_local_job()) {
    auto result = segment_here(job->payload, job->options, job->outputs, StopToken(&stop_local_, job->deadline),
                               job->prompts, job->tracking);
    const MutexLock lock(mutex_);
    scheduler_.on_local_result(job->sequence, std::move(result), Clock::now());
    notify();
  }
}

std::optional<StreamScheduler::LocalJob> StreamThreads::wait_for_local_job() {
  const MutexLock lock(mutex_);
  while (!stopping_) {
    if (auto job = scheduler_.take_local_job(Clock::now())) return job;
    changed_.wait(mutex_);  // the timer thread notifies when frames become ready
  }
  return std::nullopt;
}

void StreamThreads::on_servers_changed() {
  const MutexLock lock(mutex_);
  servers_changed_ = true;
  notify();
}

void StreamThreads::update_servers() {
  {
    const MutexLock lock(mutex_);
    if (!std::exchange(servers_changed_, false)) return;
  }
  const ServerList list = channels_->fleet().servers();
  const MutexLock lock(mutex_);
  scheduler_.set_servers(list);
}

/// The timer thread.
void StreamThreads::keep_time() {
  while (true) {
    update_servers();
    std::uint64_t seen = 0;
    StreamScheduler::Tick tick;
    std::vector<std::shared_ptr<void>> ended;
    {
      const MutexLock lock(mutex_);
      seen = changes_;
      tick = scheduler_.tick(Clock::now());
      ended = std::exchange(ended_, {});
      if (stopping_ && transports_.empty() && probes_.empty() && diagnoses_.empty() && tick.actions.empty()) return;
      // The tick may have ended frames, which concerns those who wait for outcomes or for room.
      changed_.notify_all();
    }
    ended.clear();
    if (tick.trouble) channels_->fleet().on_trouble(Clock::now());
    for (const LinkAction& action : tick.actions) perform(action);
    pump();
    const MutexLock lock(mutex_);
    const Time wake_at = std::min(tick.wake_at, scheduler_.next_dispatch(Clock::now()).value_or(tick.wake_at));
    while (changes_ == seen && changed_.wait_until(mutex_, wake_at)) {
    }
  }
}

void StreamThreads::perform(const LinkAction& action) {
  switch (action.kind) {
    case LinkAction::kOpen:
      return open(action);
    case LinkAction::kProbe:
      return probe(action);
    case LinkAction::kRenew:
    case LinkAction::kBreak:
    case LinkAction::kBreakSilent:
      return give_up(action);
  }
}

void StreamThreads::open(const LinkAction& action) {
  auto transport =
      std::make_shared<StreamTransport>(action.connection, action.server.address, channels_->get(action.server), *this);
  channels_->authorize(transport->context());
  {
    const MutexLock lock(mutex_);
    transports_[action.connection] = transport;
  }
  transport->start();
}

void StreamThreads::probe(const LinkAction& action) {
  std::shared_ptr<LivenessProbe> probe;
  {
    const MutexLock lock(mutex_);
    const auto transport = transports_.find(action.connection);
    if (transport == transports_.end() || probes_.contains(action.connection)) return;
    probe = probes_[action.connection] = std::make_shared<LivenessProbe>(transport->second->channel());
  }
  channels_->authorize(probe->context());
  probe->start(options_.progress_timeout, [this, id = action.connection](bool alive) { on_probed(id, alive); });
}

void StreamThreads::give_up(const LinkAction& action) {
  std::shared_ptr<StreamTransport> transport;
  {
    const MutexLock lock(mutex_);
    const auto probe = probes_.find(action.connection);
    if (probe != probes_.end() && action.kind != LinkAction::kRenew) probe->second->cancel();
    const auto found = transports_.find(action.connection);
    if (found == transports_.end()) return;
    transport = found->second;
  }
  if (action.kind != LinkAction::kBreak) channels_->renew(action.server, transport->channel());
  if (action.kind != LinkAction::kRenew) transport->cancel();
}

void StreamThreads::pump() {
  std::vector<std::shared_ptr<StreamTransport>> transports;
  {
    const MutexLock lock(mutex_);
    for (const auto& [id, transport] : transports_) transports.push_back(transport);
  }
  for (const auto& transport : transports) transport->pump();
}

bool StreamThreads::next_message(ConnectionId id, OutgoingMessage& outgoing) {
  const MutexLock lock(mutex_);
  const Time now = Clock::now();
  const std::uint64_t ended = scheduler_.ended();
  const auto next_before = scheduler_.next_dispatch(now);
  const bool has_next = scheduler_.next_message(id, outgoing, now);
  const bool begins_frame = has_next && outgoing.message.has_frame();
  const auto next = scheduler_.next_dispatch(now);
  const bool is_due_sooner = next && (!next_before || *next < *next_before);
  if (begins_frame || is_due_sooner || scheduler_.ended() != ended) notify();  // room, an outcome, or another wake_at
  return has_next;
}

bool StreamThreads::wants_half_close(ConnectionId id) {
  const MutexLock lock(mutex_);
  return scheduler_.wants_half_close(id);
}

void StreamThreads::on_written(ConnectionId id) {
  const MutexLock lock(mutex_);
  scheduler_.on_sign_of_life(id, Clock::now());
}

void StreamThreads::on_message(ConnectionId id, v1::SegmentStreamResponse& message) {
  const MutexLock lock(mutex_);
  if (scheduler_.on_message(id, message, Clock::now())) notify();
}

void StreamThreads::on_closed(ConnectionId id, const absl::Status& status, bool handshake_failed) {
  const MutexLock lock(mutex_);
  if (handshake_failed && !stopping_) return diagnose(id, status);
  end_connection(id, status);
}

void StreamThreads::diagnose(ConnectionId id, const absl::Status& status) {
  const std::string& address = transports_.at(id)->address();
  try {
    diagnoses_[id] = std::make_shared<std::jthread>([this, id, address, status] {
      const absl::Status fault = channels_->handshake_fault(address, kHandshakeProbeTime);
      const MutexLock lock(mutex_);
      end_connection(id, fault.ok() ? status : fault);
      ended_.push_back(std::move(diagnoses_.extract(id).mapped()));
    });
  } catch (const std::system_error&) {  // The process may start no more threads.
    diagnoses_.erase(id);
    end_connection(id, status);
  }
}

void StreamThreads::end_connection(ConnectionId id, const absl::Status& status) {
  scheduler_.on_closed(id, status, Clock::now());
  ended_.push_back(std::move(transports_.extract(id).mapped()));
  notify();
}

void StreamThreads::on_probed(ConnectionId id, bool alive) {
  const MutexLock lock(mutex_);
  if (alive) scheduler_.on_probe_answered(id, Clock::now());
  ended_.push_back(std::move(probes_.extract(id).mapped()));
  notify();
}

}  // namespace segserve::client
