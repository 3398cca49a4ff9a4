// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <optional>
#include <thread>
#include <vector>

#include "client/load_test/arrivals.hpp"
#include "client/load_test/load.hpp"
#include "client/load_test/load_report.hpp"
#include "core/base/mutex.hpp"
#include "segserve/client/stream.hpp"

namespace segserve::bench {

/// A cloud in one encoding.
struct PreparedFrame {
  std::optional<client::Payload> payload;  ///< unset: the frame is encoded each time it is sent
  std::vector<std::uint32_t> labels;       ///< of a local run; empty unless labels are verified
};

/// Everything that the clients of a load test share. It does not change while they run.
struct LoadSetup {
  const LoadOptions& options;
  const FrameSource& source;
  std::vector<std::vector<PreparedFrame>> frames = {};  ///< by encoding and cloud
  client::Time begin = {};
  client::Time measured_from = {};
  client::Time end = {};

  std::size_t encoding_of(std::size_t client) const { return client % source.encodings.size(); }
};

/// One client of a load test: a stream, a thread that sends and one that reads.
class LoadClient {
 public:
  /// `setup` must outlive the client; `index` counts the clients from 0.
  LoadClient(const LoadSetup& setup, std::size_t index, client::Stream stream);

  /// Sends from LoadSetup::begin to LoadSetup::end.
  void start();
  /// Waits for the outcomes of all frames. Returns what was measured.
  const Report& join();
  /// Why the client stopped sending early; OK if it did not. After join().
  const absl::Status& status() const { return status_; }

 private:
  struct SentFrame {
    std::size_t cloud = 0;
    client::Time intended = {}, actual = {};
    double encode_ms = 0;
  };

  void send_all();
  void send_open_loop();
  /// When frames are due, and the first of them.
  Arrivals arrivals() const;
  std::size_t first_frame() const;
  void send_closed_loop() ABSL_LOCKS_EXCLUDED(mutex_);
  bool send(std::size_t frame, client::Time intended) ABSL_LOCKS_EXCLUDED(mutex_);
  void read_all() ABSL_LOCKS_EXCLUDED(mutex_);
  void record(const client::Outcome& outcome, const SentFrame& sent);

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

  Report report_;        // of the reading thread
  absl::Status status_;  // of the sending thread
  std::thread sender_, reader_;
};

}  // namespace segserve::bench
