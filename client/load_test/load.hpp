// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>
#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "client/load_test/load_report.hpp"
#include "segserve/client/client.hpp"
#include "segserve/client/payload.hpp"

namespace segserve::bench {

/// A way of sending frames.
struct Encoding {
  std::string name;  ///< for people
  /// Makes the payload of a cloud. Several threads call it at once.
  std::function<absl::StatusOr<client::Payload>(std::shared_ptr<const Cloud>)> encode;
  wire::Compression answer_compression = wire::Compression::kNone;  ///< that arrays of results may have
};

/// The frames of a load test. Neither list may be empty.
struct FrameSource {
  std::vector<std::shared_ptr<const Cloud>> clouds;  ///< sent in turn, over and over
  std::vector<Encoding> encodings;                   ///< client i uses encodings[i % encodings.size()]
  /// When each cloud was recorded, for LoadOptions::replay_speed: seconds, ascending, at least two.
  std::vector<double> times = {};
};

struct LoadOptions {
  client::ClientOptions client;
  client::StreamOptions stream;  ///< every client has such a stream
  std::size_t clients = 1;       ///< each with connections of its own
  /// Open loop: frames per second of all clients together, each sent at its time, whatever became of those before.
  /// 0: closed loop, in which every client sends as soon as fewer than stream.max_in_flight frames have no outcome.
  double rate = 0;
  /// Open loop: every client replays the recorded clouds at their own times, so much faster. Clients begin at different
  /// clouds. 0: not. Excludes `rate`.
  double replay_speed = 0;
  bool poisson = false;                     ///< open loop: frames come at random times, see Arrivals::poisson
  std::uint64_t seed = 1;                   ///< of the random times
  std::chrono::milliseconds warm_up{1000};  ///< not measured
  std::chrono::milliseconds duration{10'000};
  bool encoded_beforehand = false;  ///< frames are encoded once, not each time
  bool verify = false;              ///< compare every label array with a local run on the decoded payload

  bool is_open() const { return rate > 0 || replay_speed > 0; }
};

/// Runs the load and waits for the outcomes of all frames. Fails for a cloud that cannot be encoded and for wrong
/// options. Errors of frames are counted instead. `progress` is called now and then with the share of the time that has
/// passed, 0 to 1.
absl::StatusOr<Report> run_load(const LoadOptions& options, const FrameSource& source,
                                const std::function<void(double)>& progress);

}  // namespace segserve::bench
