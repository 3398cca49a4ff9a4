// SPDX-License-Identifier: Apache-2.0
#include "client/load_test/load_client.hpp"

#include <algorithm>
#include <chrono>
#include <utility>

#include "fmt/format.h"

namespace segserve::bench {
namespace {

using client::Clock;
using client::Payload;
using client::Time;

// How soon a thread that waits for an outcome sees that the window or the drain was cut short.
constexpr std::chrono::milliseconds kLook{100};

double milliseconds(Clock::duration duration) { return std::chrono::duration<double, std::milli>(duration).count(); }

/// A time that never comes is a year away.
Clock::duration seconds(double value) {
  constexpr double kYear = 365.0 * 86400;
  return std::chrono::duration_cast<Clock::duration>(std::chrono::duration<double>(std::min(value, kYear)));
}

}  // namespace

LoadClient::LoadClient(const LoadSetup& setup, std::size_t index, client::Stream stream)
    : setup_(setup),
      index_(index),
      encoding_(setup.source.encodings[setup.encoding_of(index)]),
      frames_(setup.frames[setup.encoding_of(index)]),
      stream_(std::move(stream)) {}

void LoadClient::start() {
  sender_ = std::thread([this] {
    send_all();
    has_sent_ = true;
  });
  reader_ = std::thread([this] {
    read_all();
    ended_ = true;
  });
}

void LoadClient::join() {
  sender_.join();
  reader_.join();
  const MutexLock lock(mutex_);
  for (const auto& [sequence, frame] : sent_) lose_unfinished(frame);
}

void LoadClient::send_all() {
  setup_.clock.sleep_until(setup_.clock.begin());
  if (setup_.options.is_open()) {
    send_open_loop();
  } else {
    send_closed_loop();
  }
  stream_.finish();
}

/// Waits until the window has room for a frame; false if the measured window ends before.
bool LoadClient::may_send() {
  const MutexLock lock(mutex_);
  while (sent_.size() >= setup_.options.stream.max_in_flight) {
    const Time end = setup_.clock.end();
    if (Clock::now() >= end) return false;
    outcome_came_.wait_until(mutex_, std::min(end, Clock::now() + kLook));
  }
  return true;
}

/// Sends a frame whenever the window has room for one, which is the frame's intended time.
void LoadClient::send_closed_loop() {
  for (std::size_t frame = index_; may_send(); ++frame) {
    const Time now = Clock::now();
    if (now >= setup_.clock.end() || !send(frame, now)) return;
  }
}

Arrivals LoadClient::arrivals() const {
  const LoadOptions& options = setup_.options;
  if (options.replay_speed > 0) {
    return Arrivals::recorded(setup_.source.times, options.replay_speed, first_frame());
  }
  std::vector<RateSegment> segments = options.rates;
  const double first_rate = segments.front().from;
  const double warm_up = std::chrono::duration<double>(options.warm_up).count();
  if (warm_up > 0 && first_rate > 0) segments.insert(segments.begin(), {first_rate, first_rate, warm_up});
  const double share = 1 / static_cast<double>(options.clients_of_all());
  const std::size_t place = options.first_client + index_;
  RateSchedule schedule(std::move(segments));
  if (options.poisson) return Arrivals::poisson(std::move(schedule), share, options.seed * 1000 + place);
  return Arrivals::constant(std::move(schedule), share, static_cast<double>(place) * share);
}

std::size_t LoadClient::first_frame() const {
  const std::size_t place = setup_.options.first_client + index_;
  if (setup_.options.replay_speed == 0) return place;
  return place * setup_.source.times.size() / setup_.options.clients_of_all();
}

/// Sends each frame at its intended time, whatever became of those before. What is due before the end of the window and
/// cannot be sent until then is lost.
void LoadClient::send_open_loop() {
  Arrivals due = arrivals();
  for (std::size_t frame = first_frame();; ++frame) {
    const Time intended = setup_.clock.begin() + seconds(due.next());
    if (setup_.clock.sleep_until(intended)) {
      send(frame, intended);
      continue;
    }
    if (intended >= setup_.clock.end() || setup_.clock.interrupted()) return;
    setup_.recorder.on_offered(intended);
    setup_.recorder.on_lost({index_, setup_.encoding_of(index_), 0, intended}, "NOT_SENT", Clock::now());
  }
}

bool LoadClient::send(std::size_t frame, Time intended) {
  SentFrame sent{.client = index_,
                 .encoding = setup_.encoding_of(index_),
                 .cloud = frame % setup_.source.clouds.size(),
                 .intended = intended,
                 .actual = Clock::now()};
  setup_.recorder.on_offered(intended);
  const std::optional<Payload>& encoded = frames_[sent.cloud].payload;
  absl::StatusOr<Payload> payload = encoded ? *encoded : encoding_.encode(setup_.source.clouds[sent.cloud]);
  if (!payload.ok()) {
    lose(sent, payload.status());
    return false;
  }
  sent.encode_ms = encoded ? 0 : milliseconds(Clock::now() - sent.actual);
  {
    const MutexLock lock(mutex_);
    sent_[++last_sequence_] = sent;  // before the reading thread can see the outcome
  }
  setup_.recorder.on_sent(sent);
  const auto sequence = stream_.send(*std::move(payload), {.captured = sent.actual});
  if (sequence.ok()) return true;
  {
    const MutexLock lock(mutex_);
    sent_.erase(last_sequence_--);
  }
  lose(sent, sequence.status());
  // Others waited for too long, but later frames may go.
  return absl::IsDeadlineExceeded(sequence.status());
}

void LoadClient::lose(const SentFrame& frame, const absl::Status& status) {
  if (!absl::IsDeadlineExceeded(status)) status_ = status;
  setup_.recorder.on_lost(frame, fmt::format("NOT_SENT {}", absl::StatusCodeToString(status.code())), Clock::now());
}

/// Reads outcomes until the stream is done, or until the drain ends, also if more results are at hand then. All frames
/// are cancelled at its end, and outcomes are read as long as the sending thread may wait for room.
void LoadClient::read_all() {
  while (true) {
    const auto outcome = stream_.next(kLook);
    const bool drained = Clock::now() >= setup_.clock.drain_end();
    if (drained) cancel_unfinished();
    if (drained && has_sent_ && !outcome) return;
    if (!outcome) {
      if (stream_.done()) return;
      continue;
    }
    SentFrame sent;
    {
      const MutexLock lock(mutex_);
      sent = sent_.extract(outcome->sequence).mapped();
      outcome_came_.notify_one();
    }
    if (drained) {
      lose_unfinished(sent);
    } else {
      record(*outcome, sent);
    }
  }
}

void LoadClient::cancel_unfinished() {
  std::vector<std::uint64_t> sequences;
  {
    const MutexLock lock(mutex_);
    for (const auto& [sequence, frame] : sent_) sequences.push_back(sequence);
  }
  for (const std::uint64_t sequence : sequences) stream_.cancel(sequence);
}

/// Frames that had no outcome when the run was interrupted are not counted.
void LoadClient::lose_unfinished(const SentFrame& frame) {
  if (!setup_.clock.interrupted()) setup_.recorder.on_lost(frame, "UNFINISHED", Clock::now());
}

void LoadClient::record(const client::Outcome& outcome, const SentFrame& sent) {
  const Time now = Clock::now();
  FrameRecord record{.points = setup_.source.clouds[sent.cloud]->size()};
  if (setup_.options.verify && outcome.result) {
    record.verified = true;
    record.mismatch = outcome.result->segmentation.labels != frames_[sent.cloud].labels;
  }
  setup_.recorder.on_outcome(sent, outcome, record, now);
}

}  // namespace segserve::bench
