// SPDX-License-Identifier: Apache-2.0
#include "client/load_test/fault_injector.hpp"

#include <algorithm>
#include <chrono>
#include <utility>

#include "core/base/status_macros.hpp"

namespace segserve::bench {
namespace {

using client::OutcomeKind;
using std::chrono::milliseconds;

constexpr milliseconds kPause{20};
constexpr milliseconds kSlowRead{2000};
constexpr milliseconds kCallTime{3000};
constexpr milliseconds kLongestRead{86'400'000};
constexpr std::uint32_t kMostFramesOfReader = 4;                         // that a slow reader leaves unread
constexpr const char *kMalformed = "malformed", *kCancelled = "cancel";  // the request ids of their frames

}  // namespace

FaultInjector::FaultInjector(client::ClientOptions client, FaultMix mix, client::Payload payload)
    : client_(std::move(client)), mix_(mix), payload_(std::move(payload)) {}

absl::StatusOr<std::unique_ptr<FaultInjector>> FaultInjector::start(const client::ClientOptions& client,
                                                                    const client::StreamOptions& stream, FaultMix mix,
                                                                    client::Payload payload) {
  std::unique_ptr<FaultInjector> injector(new FaultInjector(client, mix, std::move(payload)));
  FaultInjector& self = *injector;
  client::StreamOptions options = stream;
  options.client_name = "segctl bench --fault";
  options.order = client::Order::kDone;
  options.when_behind = client::WhenBehind::kDropOldest;
  options.max_waiting = 64;
  options.on_outcome = [&self](const client::Outcome& outcome) { self.on_outcome(outcome); };
  ASSIGN_OR_RETURN(const client::Client connected, client::Client::connect(client));
  ASSIGN_OR_RETURN(client::Stream opened, connected.open_stream(options));
  injector->stream_ = std::make_unique<client::Stream>(std::move(opened));
  for (std::size_t i = 0; i < mix.slow_readers; ++i) {
    RawStream& reader = *injector->slow_readers_.emplace_back(std::make_unique<RawStream>(client, kLongestRead));
    injector->threads_.emplace_back([&self, &reader] { self.read_slowly(reader); });
  }
  injector->threads_.emplace_back([&self] { self.run(); });
  return injector;
}

FaultInjector::~FaultInjector() { stop(); }

std::map<std::string, std::uint64_t> FaultInjector::stop() {
  {
    const MutexLock lock(mutex_);
    stopping_ = true;
    stopped_.notify_all();
  }
  for (const auto& reader : slow_readers_) reader->cancel();
  for (std::thread& thread : threads_) thread.join();
  threads_.clear();
  stream_.reset();
  const MutexLock lock(mutex_);
  return counts_;
}

void FaultInjector::count(const std::string& kind) {
  const MutexLock lock(mutex_);
  ++counts_[kind];
}

bool FaultInjector::sleep_for(milliseconds time) {
  const auto until = client::Clock::now() + time;
  const MutexLock lock(mutex_);
  while (!stopping_ && stopped_.wait_until(mutex_, until)) {
  }
  return !stopping_;
}

/// Does of each kind what the frames of the load call for.
void FaultInjector::run() {
  struct Kind {
    double share;
    void (FaultInjector::*act)();
    std::uint64_t done = 0;
  };
  std::vector<Kind> kinds = {{mix_.vanish, &FaultInjector::vanish},
                             {mix_.malformed, &FaultInjector::send_malformed},
                             {mix_.cancel, &FaultInjector::send_and_cancel}};
  while (sleep_for(kPause)) {
    for (Kind& kind : kinds) {
      if (static_cast<double>(kind.done) + 1 > kind.share * static_cast<double>(frames_)) continue;
      ++kind.done;
      (this->*kind.act)();
    }
  }
}

void FaultInjector::read_slowly(RawStream& stream) {
  if (!stream.open("segctl bench --fault slow-reader")) return count("not_connected");
  count("slow-reader");
  const std::uint32_t frames = std::clamp<std::uint32_t>(stream.credit(), 1, kMostFramesOfReader);
  for (std::uint32_t i = 0; i < frames; ++i) {
    if (!stream.send_frame(payload_, 0)) return;
  }
  while (sleep_for(kSlowRead) && stream.read()) {
  }
}

void FaultInjector::vanish() {
  RawStream stream(client_, kCallTime);
  if (!stream.open("segctl bench --fault vanish")) return count("not_connected");
  stream.send_frame(payload_, payload_.bytes() / 2);
  count("vanish");
}

void FaultInjector::send_malformed() {
  const auto sequence =
      stream_->send(client::pcd_payload("VERSION 0.7\nFIELDS no cloud\n"), {.request_id = kMalformed});
  count(sequence.ok() ? kMalformed : "not_connected");
}

void FaultInjector::send_and_cancel() {
  const auto sequence = stream_->send(payload_, {.request_id = kCancelled});
  if (!sequence.ok()) return count("not_connected");
  stream_->cancel(*sequence);
  count(kCancelled);
}

void FaultInjector::on_outcome(const client::Outcome& outcome) {
  const bool is_malformed = outcome.request_id == kMalformed;
  const bool is_refused = outcome.kind == OutcomeKind::kFailed && absl::IsInvalidArgument(outcome.status);
  if (is_malformed && outcome.kind == OutcomeKind::kResult) count("malformed_not_refused");
  if (is_malformed && outcome.kind == OutcomeKind::kFailed && !is_refused) count("malformed_failed_otherwise");
  if (!is_malformed && outcome.kind == OutcomeKind::kResult) count("cancel_too_late");
}

}  // namespace segserve::bench
