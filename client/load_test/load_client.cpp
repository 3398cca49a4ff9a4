// SPDX-License-Identifier: Apache-2.0
#include "client/load_test/load_client.hpp"

#include <chrono>
#include <utility>

namespace segserve::bench {
namespace {

using client::Clock;
using client::Payload;
using client::Time;

double milliseconds(Clock::duration duration) { return std::chrono::duration<double, std::milli>(duration).count(); }

Clock::duration seconds(double value) {
  return std::chrono::duration_cast<Clock::duration>(std::chrono::duration<double>(value));
}

}  // namespace

LoadClient::LoadClient(const LoadSetup& setup, std::size_t index, client::Stream stream)
    : setup_(setup),
      index_(index),
      encoding_(setup.source.encodings[setup.encoding_of(index)]),
      frames_(setup.frames[setup.encoding_of(index)]),
      stream_(std::move(stream)) {}

void LoadClient::start() {
  sender_ = std::thread([this] { send_all(); });
  reader_ = std::thread([this] { read_all(); });
}

const Report& LoadClient::join() {
  sender_.join();
  reader_.join();
  return report_;
}

void LoadClient::send_all() {
  std::this_thread::sleep_until(setup_.begin);
  if (setup_.options.is_open()) {
    send_open_loop();
  } else {
    send_closed_loop();
  }
  stream_.finish();
}

/// Sends a frame whenever the window has room for one, which is the frame's intended time.
void LoadClient::send_closed_loop() {
  for (std::size_t frame = index_;; ++frame) {
    {
      const MutexLock lock(mutex_);
      while (sent_.size() >= setup_.options.stream.max_in_flight) outcome_came_.wait(mutex_);
    }
    const Time now = Clock::now();
    if (now >= setup_.end || !send(frame, now)) return;
  }
}

Arrivals LoadClient::arrivals() const {
  const LoadOptions& options = setup_.options;
  if (options.replay_speed > 0) {
    return Arrivals::recorded(setup_.source.times, options.replay_speed, first_frame());
  }
  const double rate = options.rate / static_cast<double>(options.clients);
  const double share = static_cast<double>(index_) / static_cast<double>(options.clients);
  return options.poisson ? Arrivals::poisson(rate, options.seed * 1000 + index_) : Arrivals::constant(rate, share);
}

std::size_t LoadClient::first_frame() const {
  if (setup_.options.replay_speed == 0) return index_;
  return index_ * setup_.source.times.size() / setup_.options.clients;
}

/// Sends each frame at its intended time, whatever became of those before.
void LoadClient::send_open_loop() {
  Arrivals due = arrivals();
  for (std::size_t frame = first_frame();; ++frame) {
    const Time intended = setup_.begin + seconds(due.next());
    if (intended >= setup_.end) return;
    std::this_thread::sleep_until(intended);
    if (!send(frame, intended)) return;
  }
}

bool LoadClient::send(std::size_t frame, Time intended) {
  SentFrame sent{.cloud = frame % setup_.source.clouds.size(), .intended = intended, .actual = Clock::now()};
  const std::optional<Payload>& encoded = frames_[sent.cloud].payload;
  absl::StatusOr<Payload> payload = encoded ? *encoded : encoding_.encode(setup_.source.clouds[sent.cloud]);
  if (!payload.ok()) {
    status_ = payload.status();
    return false;
  }
  sent.encode_ms = encoded ? 0 : milliseconds(Clock::now() - sent.actual);
  {
    const MutexLock lock(mutex_);
    sent_[++last_sequence_] = sent;  // before the reading thread can see the outcome
  }
  const auto sequence = stream_.send(*std::move(payload), {.captured = sent.actual});
  if (sequence.ok()) return true;
  status_ = sequence.status();
  return false;
}

void LoadClient::read_all() {
  while (const auto outcome = stream_.next()) {
    SentFrame sent;
    {
      const MutexLock lock(mutex_);
      sent = sent_.extract(outcome->sequence).mapped();
      outcome_came_.notify_one();
    }
    record(*outcome, sent);
  }
}

void LoadClient::record(const client::Outcome& outcome, const SentFrame& sent) {
  if (sent.intended < setup_.measured_from) return;
  const Time now = Clock::now();
  FrameRecord record{.latency_ms = milliseconds(now - sent.intended),
                     .since_sent_ms = milliseconds(now - sent.actual),
                     .client_encode_ms = sent.encode_ms,
                     .late_ms = milliseconds(sent.actual - sent.intended),
                     .points = setup_.source.clouds[sent.cloud]->size()};
  if (setup_.options.verify && outcome.result) {
    ++report_.verified;
    record.mismatch = outcome.result->segmentation.labels != frames_[sent.cloud].labels;
  }
  report_.add(outcome, record);
}

}  // namespace segserve::bench
