// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <atomic>
#include <cstdint>
#include <map>
#include <memory>
#include <string>
#include <thread>
#include <vector>

#include "absl/status/statusor.h"
#include "client/load_test/fault_mix.hpp"
#include "client/load_test/raw_stream.hpp"
#include "core/base/mutex.hpp"
#include "segserve/client/client.hpp"
#include "segserve/client/payload.hpp"

namespace segserve::bench {

/// Clients that misbehave while a load test runs, on connections of their own. Their frames are never counted among
/// those that are measured.
class FaultInjector {
 public:
  /// `payload` is a whole frame. Errors as of client::Client::connect and open_stream.
  static absl::StatusOr<std::unique_ptr<FaultInjector>> start(const client::ClientOptions& client,
                                                              const client::StreamOptions& stream, FaultMix mix,
                                                              client::Payload payload);
  ~FaultInjector();
  FaultInjector(const FaultInjector&) = delete;
  FaultInjector& operator=(const FaultInjector&) = delete;

  /// Tells that so many more frames of the load were sent.
  void on_frames(std::uint64_t count) { frames_ += count; }
  /// Ends all misbehavior, and returns how often each kind of it happened. Frames that did not end as they should are
  /// "malformed_not_refused", and those whose cancel came too late "cancel_too_late". A connection that could not be
  /// made is "not_connected".
  std::map<std::string, std::uint64_t> stop() ABSL_LOCKS_EXCLUDED(mutex_);

 private:
  FaultInjector(client::ClientOptions client, FaultMix mix, client::Payload payload);

  void run() ABSL_LOCKS_EXCLUDED(mutex_);
  void read_slowly(RawStream& stream) ABSL_LOCKS_EXCLUDED(mutex_);
  void vanish() ABSL_LOCKS_EXCLUDED(mutex_);
  void send_malformed() ABSL_LOCKS_EXCLUDED(mutex_);
  void send_and_cancel() ABSL_LOCKS_EXCLUDED(mutex_);
  void on_outcome(const client::Outcome& outcome) ABSL_LOCKS_EXCLUDED(mutex_);
  void count(const std::string& kind) ABSL_LOCKS_EXCLUDED(mutex_);
  /// False once stop() was called, which is told at once.
  bool sleep_for(std::chrono::milliseconds time) ABSL_LOCKS_EXCLUDED(mutex_);

  const client::ClientOptions client_;
  const FaultMix mix_;
  const client::Payload payload_;
  std::atomic<std::uint64_t> frames_{0};

  Mutex mutex_;
  CondVar stopped_;
  bool stopping_ ABSL_GUARDED_BY(mutex_) = false;
  std::map<std::string, std::uint64_t> counts_ ABSL_GUARDED_BY(mutex_);
  std::unique_ptr<client::Stream> stream_;  // of malformed and of cancelled frames
  std::vector<std::unique_ptr<RawStream>> slow_readers_;
  std::vector<std::thread> threads_;
};

}  // namespace segserve::bench
