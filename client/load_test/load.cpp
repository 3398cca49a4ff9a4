// SPDX-License-Identifier: Apache-2.0
#include "client/load_test/load.hpp"

#include <sys/resource.h>

#include <algorithm>
#include <memory>
#include <thread>
#include <utility>

#include "client/calls/local.hpp"
#include "client/load_test/load_client.hpp"
#include "core/base/status_macros.hpp"

namespace segserve::bench {
namespace {

using client::Clock;
using client::Time;

double seconds_between(Time begin, Time end) { return std::chrono::duration<double>(end - begin).count(); }

/// CPU time of this process so far, seconds.
double cpu_seconds() {
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  const auto in_seconds = [](const timeval& time) {
    return static_cast<double>(time.tv_sec) + 1e-6 * static_cast<double>(time.tv_usec);
  };
  return in_seconds(usage.ru_utime) + in_seconds(usage.ru_stime);
}

/// Encodes a frame, and segments it in this process if labels are verified. Encodes it even if that is repeated for
/// each frame that is sent: errors are found before the run.
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

/// Prepares every cloud in every encoding that is used.
absl::Status prepare_frames(LoadSetup& setup) {
  for (std::size_t i = 0; i < std::min(setup.source.encodings.size(), setup.options.clients); ++i) {
    std::vector<PreparedFrame>& frames = setup.frames.emplace_back();
    for (const std::shared_ptr<const Cloud>& cloud : setup.source.clouds) {
      ASSIGN_OR_RETURN(frames.emplace_back(), prepare_frame(setup.options, setup.source.encodings[i], cloud));
    }
  }
  return absl::OkStatus();
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

/// Reports the progress until a time has come.
void wait_until(Time until, const LoadSetup& setup, const std::function<void(double)>& progress) {
  for (Time now = Clock::now(); now < until; now = Clock::now()) {
    const double share = seconds_between(setup.begin, now) / seconds_between(setup.begin, setup.end);
    progress(std::clamp(share, 0.0, 1.0));
    std::this_thread::sleep_until(std::min(until, now + std::chrono::milliseconds(200)));
  }
}

}  // namespace

absl::StatusOr<Report> run_load(const LoadOptions& options, const FrameSource& source,
                                const std::function<void(double)>& progress) {
  LoadSetup setup{.options = options, .source = source};
  RETURN_IF_ERROR(prepare_frames(setup));
  ASSIGN_OR_RETURN(const LoadClients clients, make_clients(setup));
  setup.begin = Clock::now() + std::chrono::milliseconds(50);
  setup.measured_from = setup.begin + options.warm_up;
  setup.end = setup.measured_from + options.duration;
  for (const auto& client : clients) client->start();

  wait_until(setup.measured_from, setup, progress);
  const double cpu_before = cpu_seconds();
  wait_until(setup.end, setup, progress);
  Report report;
  report.cpu_seconds = cpu_seconds() - cpu_before;
  absl::Status status;
  for (const auto& client : clients) {
    const Report& own = client->join();
    report.add(own);
    report.results_of_client.push_back(own.results);
    if (!client->status().ok()) status = client->status();
  }
  // Frames that began within the span and ended after it count, and so does the time they took.
  report.seconds = seconds_between(setup.measured_from, std::max(Clock::now(), setup.end));
  if (report.sent == 0 && !status.ok()) return status;
  return report;
}

}  // namespace segserve::bench
