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

/// A way in which frames are sent.
struct Encoding {
  std::string name;  ///< for people
  /// Any codec, to be called by several threads at once.
  std::function<absl::StatusOr<client::Payload>(std::shared_ptr<const Cloud>)> encode;
  v1::Compression of_answer = v1::COMPRESSION_NONE;  ///< what arrays of the results may have
};

/// How frames are made. Neither list may be empty.
struct FrameSource {
  std::vector<std::shared_ptr<const Cloud>> clouds;  ///< sent in turn, again and again
  std::vector<Encoding> encodings;                   ///< client i uses the one of i modulo their number
};

struct LoadOptions {
  client::ClientOptions client;
  client::StreamOptions stream;  ///< of every client
  std::size_t clients = 1;       ///< each with connections of its own
  /// Frames per second of all clients together, sent at their time whatever became of those before (open loop);
  /// 0: every client sends as soon as its window has room (closed loop, max_in_flight at a time).
  double rate = 0;
  bool poisson = false;  ///< open loop: random arrivals
  std::uint64_t seed = 1;
  std::chrono::milliseconds warm_up{1000};  ///< not measured
  std::chrono::milliseconds duration{10'000};
  bool encoded_beforehand = false;  ///< frames are encoded once, not each time
  bool verify = false;              ///< compare every label array with a local run on the decoded payload
};

/// Runs the load and waits for the outcomes of all frames. Errors: a frame that cannot be encoded, wrong options; never
/// those of frames, which are counted. `progress` is called now and then with the share of the time that is over.
absl::StatusOr<Report> run_load(const LoadOptions& options, const FrameSource& source,
                                const std::function<void(double)>& progress);

}  // namespace segserve::bench
