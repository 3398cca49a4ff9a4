// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <map>
#include <string>
#include <thread>
#include <vector>

#include "client/load_test/arrivals.hpp"
#include "client/load_test/load.hpp"
#include "client/load_test/recorder.hpp"
#include "client/load_test/run_clock.hpp"
#include "core/base/mutex.hpp"
#include "segserve/client/stream.hpp"

namespace segserve::bench {

/// Everything that the clients of a load test share.
struct LoadSetup {
  const LoadOptions& options;
  const FrameSource& source;
  const PreparedFrames& frames;
  RunClock& clock;
  Recorder& recorder;

  std::size_t encoding_of(std::size_t client) const {
    return (options.first_client + client) % source.encodings.size();
  }
};

/// One client of a load test: a stream, a thread that sends and one that reads.
class LoadClient {
 public:
  /// `setup` must outlive the client; `index` counts the clients from 0.
  LoadClient(const LoadSetup& setup, std::size_t index, client::Stream stream);

  /// Sends during the warm-up and the measured window, and reads until the end of the drain.
  void start();
  /// Whether join() waits for nothing that takes time.
  bool ended() const { return ended_; }
  /// Waits for the threads. Frames without an outcome count as lost then, unless the run was interrupted.
  void join() ABSL_LOCKS_EXCLUDED(mutex_);
  /// Why no server will ever take a frame of this client; OK if that is not so. After join().
  const absl::Status& status() const { return status_; }

 private:
  void send_all();
  void send_open_loop();
  void send_closed_loop() ABSL_LOCKS_EXCLUDED(mutex_);
  /// When frames are due, and the first of them.
  Arrivals arrivals() const;
  std::size_t first_frame() const;
  bool may_send() ABSL_LOCKS_EXCLUDED(mutex_);
  /// Whether a closed loop may go on.
  bool send(std::size_t frame, client::Time intended) ABSL_LOCKS_EXCLUDED(mutex_);
  /// Counts a frame that was not handed over. `status` says why.
  void lose(const SentFrame& frame, const absl::Status& status);
  void read_all() ABSL_LOCKS_EXCLUDED(mutex_);
  void record(const client::Outcome& outcome, const SentFrame& sent);
  void lose_unfinished(const SentFrame& frame);
  void cancel_unfinished() ABSL_LOCKS_EXCLUDED(mutex_);

  const LoadSetup& setup_;
  const std::size_t index_;
  const Encoding& encoding_;
  const std::vector<PreparedFrame>& frames_;
  client::Stream stream_;

  Mutex mutex_;
  CondVar outcome_came_;
  /// Frames without an outcome, by the sequence of the stream.
  std::map<std::uint64_t, SentFrame> sent_ ABSL_GUARDED_BY(mutex_);
  std::uint64_t last_sequence_ ABSL_GUARDED_BY(mutex_) = 0;

  std::atomic<bool> has_sent_{false};  // all that it will send
  std::atomic<bool> ended_{false};
  absl::Status status_;  // of the sending thread
  std::thread sender_, reader_;
};

}  // namespace segserve::bench
