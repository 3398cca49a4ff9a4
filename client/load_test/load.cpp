// SPDX-License-Identifier: Apache-2.0
#include "client/load_test/load.hpp"

#include <algorithm>
#include <chrono>
#include <memory>
#include <optional>
#include <thread>
#include <utility>

#include "client/calls/local.hpp"
#include "client/load_test/load_client.hpp"
#include "client/load_test/process_cost.hpp"
#include "client/load_test/recorder.hpp"
#include "client/load_test/run_clock.hpp"
#include "core/base/status_macros.hpp"

namespace segserve::bench {
namespace {

using client::Clock;
using client::Time;

// The time for outcomes that are on their way when a run is interrupted.
constexpr std::chrono::milliseconds kInterruptedDrain{500};

double seconds_between(Time begin, Time end) { return std::chrono::duration<double>(end - begin).count(); }

/// Encodes a frame even if that is repeated for each frame that is sent: errors are found before the run.
absl::StatusOr<PreparedFrame> prepare_frame(const LoadOptions& options, const Encoding& encoding,
                                            const std::shared_ptr<const Cloud>& cloud) {
  PreparedFrame frame;
  ASSIGN_OR_RETURN(client::Payload payload, encoding.encode(cloud));
  if (options.verify) {
    ASSIGN_OR_RETURN(client::Result local, client::segment_here(payload, options.stream.options, {}, StopToken()));
    frame.labels = std::move(local.segmentation.labels);
  }
  if (options.encoded_beforehand) frame.payload = std::move(payload);
  return frame;
}

using LoadClients = std::vector<std::unique_ptr<LoadClient>>;

absl::StatusOr<LoadClients> make_clients(const LoadSetup& setup) {
  LoadClients clients;
  for (std::size_t i = 0; i < setup.options.clients; ++i) {
    ASSIGN_OR_RETURN(const client::Client client, client::Client::connect(setup.options.client));
    client::StreamOptions options = setup.options.stream;
    options.outputs.compression = setup.source.encodings[setup.encoding_of(i)].answer_compression;
    ASSIGN_OR_RETURN(client::Stream stream, client.open_stream(options));
    clients.push_back(std::make_unique<LoadClient>(setup, i, std::move(stream)));
  }
  return clients;
}

/// When each level ends, from the begin of the measured window.
std::vector<Clock::duration> level_ends(const LoadOptions& options) {
  if (options.levels.empty()) return {options.duration};
  std::vector<Clock::duration> ends;
  ends.reserve(options.levels.size());
  Clock::duration end(0);
  for (const auto length : options.levels) ends.push_back(end += length);
  return ends;
}

/// Watches over a run: closes the intervals of the timeline, tells the observer, measures this process, and ends the
/// window early if it must.
class Watch {
 public:
  Watch(const LoadOptions& options, RunClock& clock, Recorder& recorder, const LoadObserver& observer)
      : options_(options), clock_(clock), recorder_(recorder), observer_(observer), level_ends_(level_ends(options)) {}

  /// Waits until all clients have ended.
  void wait_for(const LoadClients& clients) {
    while (true) {
      const Time now = Clock::now();
      look(now);
      if (std::ranges::all_of(clients, [](const auto& client) { return client->ended(); })) break;
      Time next = now + std::chrono::milliseconds(50);
      for (const Time edge : {clock_.measured_from(), clock_.end()}) {
        if (edge > now) next = std::min(next, edge);
      }
      std::this_thread::sleep_until(next);
    }
    close_interval(Clock::now(), true);
  }
  /// CPU time of this process in the measured window.
  double window_cpu_seconds() const { return cpu_at_end_.value_or(cpu_seconds()) - cpu_at_begin_.value_or(0); }

 private:
  void look(Time now) {
    if (!cpu_at_begin_ && now >= clock_.measured_from()) cpu_at_begin_ = cpu_seconds();
    if (!cpu_at_end_ && now >= clock_.end()) cpu_at_end_ = cpu_seconds();
    close_interval(now, false);
    if (observer_.on_progress) {
      const Time planned_end = clock_.measured_from() + options_.duration;
      const double share = seconds_between(clock_.begin(), now) / seconds_between(clock_.begin(), planned_end);
      observer_.on_progress(std::clamp(share, 0.0, 1.0));
    }
    if (!clock_.interrupted() && options_.interrupt != nullptr && *options_.interrupt) {
      clock_.interrupt(now, std::min<Clock::duration>(options_.drain, kInterruptedDrain));
    }
    look_at_levels(now);
  }

  void look_at_levels(Time now) {
    if (now >= clock_.end() || now < clock_.measured_from() + level_ends_[levels_done_]) return;
    ++levels_done_;
    if (!observer_.on_level) return;
    std::vector<Report> levels;
    for (std::size_t i = 0; i < levels_done_; ++i) levels.push_back(recorder_.of_level(i));
    if (observer_.on_level(levels)) {
      clock_.stop(clock_.measured_from() + level_ends_[levels_done_ - 1], options_.drain);
    }
  }

  void close_interval(Time now, bool at_once) {
    const double cpu = cpu_seconds();
    if (recorder_.close_interval(now, cpu - cpu_before_, resident_bytes(), at_once, observer_.on_interval)) {
      cpu_before_ = cpu;
    }
  }

  const LoadOptions& options_;
  RunClock& clock_;
  Recorder& recorder_;
  const LoadObserver& observer_;
  const std::vector<Clock::duration> level_ends_;
  std::size_t levels_done_ = 0;  // whose time is over
  double cpu_before_ = cpu_seconds();
  std::optional<double> cpu_at_begin_, cpu_at_end_;
};

LoadResult result_of(const Recorder& recorder) {
  LoadResult result;
  for (std::size_t level = 0; level < recorder.levels(); ++level) {
    std::vector<Report> parts = recorder.parts_of(level);
    if (parts.front().seconds > 0) result.parts.push_back(std::move(parts));
  }
  if (result.parts.empty()) result.parts.push_back(recorder.parts_of(0));  // interrupted in the warm-up
  result.timeline = recorder.timeline();
  result.summarize();
  result.finished = result.total.finished;
  return result;
}

}  // namespace

void LoadResult::summarize() {
  total = {};
  levels.clear();
  codecs.assign(parts.front().size(), {});
  for (const std::vector<Report>& level : parts) {
    Report& sum = levels.emplace_back();
    for (std::size_t i = 0; i < level.size(); ++i) {
      sum.add(level[i]);
      sum.seconds = std::max(sum.seconds, level[i].seconds);
      codecs[i].add(level[i]);
      codecs[i].seconds += level[i].seconds;
    }
    total.add(sum);
    total.seconds += sum.seconds;
  }
}

void LoadResult::append(const LoadResult& later) {
  const double begin = window_s;
  for (TimelineEntry entry : later.timeline) {
    entry.t += begin;
    timeline.push_back(entry);
  }
  std::vector<Report>& level = parts.emplace_back(later.codecs);
  level.resize(std::max(level.size(), parts.front().size()));
  for (std::vector<Report>& each : parts) each.resize(level.size());
  window_s += later.window_s;
  drain_s = later.drain_s;
  cpu_seconds += later.cpu_seconds;
  cpus = std::max(cpus, later.cpus);
  finished += later.finished;
  interrupted = later.interrupted;
  summarize();
}

double LoadResult::cpu_ms_per_frame() const {
  return finished == 0 ? 0 : 1000 * cpu_seconds / static_cast<double>(finished);
}

double LoadResult::busy_cpus() const { return window_s > 0 ? cpu_seconds / window_s : 0; }

absl::StatusOr<PreparedFrames> prepare_frames(const LoadOptions& options, const FrameSource& source) {
  PreparedFrames all;
  for (std::size_t i = 0; i < std::min(source.encodings.size(), options.clients_of_all()); ++i) {
    std::vector<PreparedFrame>& frames = all.emplace_back();
    for (const std::shared_ptr<const Cloud>& cloud : source.clouds) {
      ASSIGN_OR_RETURN(frames.emplace_back(), prepare_frame(options, source.encodings[i], cloud));
    }
  }
  return all;
}

absl::StatusOr<LoadResult> run_load(const LoadOptions& options, const FrameSource& source, const PreparedFrames& frames,
                                    const LoadObserver& observer) {
  RunClock clock(Clock::now() + std::chrono::milliseconds(50), options.warm_up, options.duration, options.drain);
  Recorder recorder(clock, level_ends(options), frames.size(), options.clients, options.interval_s);
  const LoadSetup setup{options, source, frames, clock, recorder};
  ASSIGN_OR_RETURN(const LoadClients clients, make_clients(setup));
  for (const auto& client : clients) client->start();
  if (observer.on_start) observer.on_start([&recorder] { return recorder.total(); });
  Watch watch(options, clock, recorder, observer);
  watch.wait_for(clients);
  const Time drained = std::min(Clock::now(), clock.drain_end());

  absl::Status status;
  for (const auto& client : clients) {
    client->join();
    if (!client->status().ok()) status = client->status();
  }
  if (observer.on_end) observer.on_end();
  LoadResult result = result_of(recorder);
  if (result.total.results == 0 && !status.ok()) return status;
  result.window_s = std::max(0.0, seconds_between(clock.measured_from(), clock.end()));
  result.cpu_seconds = watch.window_cpu_seconds();
  result.warm_up_s =
      std::min(seconds_between(clock.begin(), clock.measured_from()), seconds_between(clock.begin(), clock.end()));
  result.drain_s = std::max(0.0, seconds_between(clock.end(), drained));
  result.cpus = usable_cpus();
  result.interrupted = clock.interrupted();
  return result;
}

}  // namespace segserve::bench
