// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <atomic>
#include <chrono>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "client/load_test/arrivals.hpp"
#include "client/load_test/load_report.hpp"
#include "client/load_test/timeline.hpp"
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
  /// These clients are those from this number on of a load with more of them, which other processes run; 0: there are
  /// no others. An open loop has its share of the frames, a closed one sends as it does alone.
  std::size_t first_client = 0, all_clients = 0;
  /// Open loop: frames per second of all clients together, each sent at its time, whatever became of those before. The
  /// segments begin with the measured window; the warm-up has the rate with which the first one begins. Empty: closed
  /// loop, in which every client sends as soon as fewer than stream.max_in_flight frames have no outcome.
  std::vector<RateSegment> rates = {};
  /// Open loop: every client replays the recorded clouds at their own times, so much faster. Clients begin at different
  /// clouds. 0: not. Excludes `rates`.
  double replay_speed = 0;
  bool poisson = false;                     ///< open loop: frames come at random times, see Arrivals::poisson
  std::uint64_t seed = 1;                   ///< of the random times
  std::chrono::milliseconds warm_up{1000};  ///< not measured
  std::chrono::milliseconds duration{10'000};
  /// Parts of the duration that are reported on their own, as long as it together; empty: one.
  std::vector<std::chrono::milliseconds> levels = {};
  /// How long outcomes are waited for when no more frames are sent. What has none then counts as failed.
  std::chrono::milliseconds drain{10'000};
  bool encoded_beforehand = false;               ///< frames are encoded once, not each time
  bool verify = false;                           ///< compare every label array with a local run on the decoded payload
  double interval_s = 1;                         ///< of the timeline
  const std::atomic<bool>* interrupt = nullptr;  ///< once it is true, the window ends; may be null

  std::size_t clients_of_all() const { return all_clients == 0 ? clients : all_clients; }
  bool is_open() const { return !rates.empty() || replay_speed > 0; }
};

/// The measurements of a run.
struct LoadResult {
  /// The reports by level and by encoding, in the order of LoadOptions::levels and FrameSource::encodings; only those
  /// that had some time, but at least one.
  std::vector<std::vector<Report>> parts;
  // The sums of `parts`.
  Report total;
  std::vector<Report> levels, codecs;

  std::vector<TimelineEntry> timeline;
  double warm_up_s = 0, window_s = 0, drain_s = 0;
  double cpu_seconds = 0;      ///< that this process used within the measured window
  std::uint64_t finished = 0;  ///< results that came within it, also in levels that are not among `parts` any more
  unsigned cpus = 0;           ///< that it may use
  bool interrupted = false;    ///< frames that had no outcome then are not counted

  /// Makes the sums of `parts`.
  void summarize();
  /// Adds a run that came after this one, as one more level.
  void append(const LoadResult& later);
  /// Time of one CPU for each result that came within the window.
  double cpu_ms_per_frame() const;
  /// The number of CPUs that this process kept busy.
  double busy_cpus() const;
};

/// Hears of a run while it goes on, on the thread that runs it. Each of them may be empty.
struct LoadObserver {
  /// Called now and then, with the share of the time that has passed, 0 to 1.
  std::function<void(double)> on_progress = nullptr;
  /// Called at the end of each interval of the timeline, with the latencies of its results in microseconds.
  std::function<void(const TimelineEntry&, const HdrHistogram&)> on_interval = nullptr;
  /// Called at the beginning, with a function for the frames so far that any thread may call until on_end returns.
  std::function<void(std::function<Report()>)> on_start = nullptr;
  /// Called at the end.
  std::function<void()> on_end = nullptr;
  /// Called at the end of each level but the last, with the levels so far. If it returns true, the window ends.
  std::function<bool(const std::vector<Report>&)> on_level = nullptr;
};

/// A cloud in one encoding.
struct PreparedFrame {
  std::optional<client::Payload> payload;  ///< unset: the frame is encoded each time it is sent
  std::vector<std::uint32_t> labels;       ///< of a local run; empty unless labels are verified
};

/// The frames by encoding and cloud.
using PreparedFrames = std::vector<std::vector<PreparedFrame>>;

/// Encodes each cloud in each encoding that so many clients use, and segments it in this process if labels are
/// verified. Fails for a cloud that cannot be encoded.
absl::StatusOr<PreparedFrames> prepare_frames(const LoadOptions& options, const FrameSource& source);

/// Runs the load. It takes warm-up, duration, and at most the drain. Fails for wrong options, and if no client ever got
/// a result because no server will take its frames. Errors of frames are counted instead.
absl::StatusOr<LoadResult> run_load(const LoadOptions& options, const FrameSource& source, const PreparedFrames& frames,
                                    const LoadObserver& observer);

}  // namespace segserve::bench
