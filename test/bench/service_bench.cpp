// SPDX-License-Identifier: Apache-2.0
// Measures what the service adds to the segmentation. Run: service_bench [frames]
//
// 1. A stream sends raw frames of 307,200 points over loopback, one at a time; client and server are in this process.
//    The overhead is the time from handing over the cloud until its labels are there, minus the stages of the
//    segmentation.
// 2. The throughput of two workers is divided by that of one, without transport.
// 3. A frame with a result is counted by the metrics, by one thread and by two at once.
#include <malloc.h>

#include <algorithm>
#include <chrono>
#include <cstdlib>
#include <memory>
#include <string_view>
#include <thread>
#include <vector>

#include "fmt/format.h"
#include "segserve/client/client.hpp"
#include "server/frames/segmentation_backend.hpp"
#include "server/metrics/service_metrics.hpp"
#include "server/scheduling/worker_pool.hpp"
#include "server/server.hpp"
#include "test/bench/frames.hpp"

namespace segserve::bench {
namespace {

using Clock = std::chrono::steady_clock;

double ms_between(Clock::time_point begin, Clock::time_point end) {
  return std::chrono::duration<double, std::milli>(end - begin).count();
}

double ms_since(Clock::time_point begin) { return ms_between(begin, Clock::now()); }

double median(std::vector<double> values) {
  std::ranges::nth_element(values, values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2));
  return values[values.size() / 2];
}

const Frame& frame_named(std::string_view name) { return *std::ranges::find(frames(), name, &Frame::name); }

/// Prints medians over `count` frames.
void measure_overhead(int count) {
  server::ServerOptions server_options;
  server_options.listen = "127.0.0.1:0";
  server_options.workers = 1;
  const auto server = server::Server::start(server_options).value();
  const auto client = client::Client::connect({.address = server->address()}).value();
  Options options;
  options.method = Method::kLambdaConvex;
  auto stream = client.open_stream({.options = options, .outputs = {.labels = true}}).value();
  const auto cloud = std::make_shared<const Cloud>(frame_named("synthetic-full").cloud);
  std::vector<double> calls, overheads, waits, decodes, encodes, client_decodes;
  for (int i = -5; i < count; ++i) {  // Negative numbers are frames that warm up.
    const Clock::time_point begin = Clock::now();
    if (!stream.send(cloud).ok()) return;
    const auto outcome = stream.next();
    const double call = ms_since(begin);
    if (!outcome || !outcome->result) return;
    if (i < 0) continue;
    calls.push_back(call);
    overheads.push_back(call - outcome->result->segmentation.timings.total);
    waits.push_back(ms_between(begin, outcome->report.header_sent));
    decodes.push_back(outcome->result->timings.decode);
    encodes.push_back(outcome->result->timings.encode);
    client_decodes.push_back(outcome->report.decode_ms);
  }
  fmt::print("one raw frame of {} points at a time: call {:.1f} ms, of which outside of the segmentation {:.1f} ms\n",
             cloud->size(), median(calls), median(overheads));
  const double known = median(waits) + median(decodes) + median(encodes) + median(client_decodes);
  fmt::print(
      "  of which: client's encoding {:.1f}, server's decoding {:.1f} and encoding {:.1f}, client's decoding {:.1f}, "
      "transport {:.1f} ms\n",
      median(waits), median(decodes), median(encodes), median(client_decodes), median(overheads) - known);
}

/// The throughput of `workers` workers.
double frames_per_second(std::size_t workers, int count) {
  std::vector<std::unique_ptr<server::SegmentationBackend>> segmenters(workers);
  std::ranges::generate(segmenters, server::core_backend_factory());
  const Cloud& cloud = frames().front().cloud;
  for (auto& segmenter : segmenters) (void)segmenter->segment(cloud, {}, {}, nullptr);
  const Clock::time_point begin = Clock::now();
  {
    server::WorkerPool pool(workers, {.jobs = 1'000'000, .bytes = 1, .points = 1});
    for (int i = 0; i < count; ++i) {
      pool.submit({.client = "bench"},
                  {.run = [&](std::size_t worker) { (void)segmenters[worker]->segment(cloud, {}, {}, nullptr); }});
    }
  }  // The destructor waits until all jobs are done.
  return count / ms_since(begin) * 1000;
}

void measure_workers(int count) {
  std::vector<double> ratios;
  double one = 0, two = 0;
  for (int round = 0; round < 5; ++round) {  // They take turns, so that other load on the machine affects both.
    one = frames_per_second(1, count);
    two = frames_per_second(2, 2 * count);
    ratios.push_back(two / one);
  }
  fmt::print("two workers, no transport: {:.1f} frames/s, {:.2f}x the {:.1f} of one\n", two, median(ratios), one);
}

/// A frame that came through all stages.
server::FrameRecord counted_frame() {
  server::FrameRecord frame;
  frame.caller = std::make_shared<const server::Caller>();
  frame.payload_kind = v1::PAYLOAD_KIND_PLANAR;
  frame.outcome = v1::OUTCOME_KIND_RESULT;
  frame.arrival = Clock::now();
  frame.uploaded = frame.queued = frame.work.started = frame.work.decoded = frame.arrival;
  frame.work.segmented = frame.work.encoded = frame.decided = frame.arrival + std::chrono::milliseconds(17);
  frame.delivered = frame.decided;
  return frame;
}

void measure_metrics() {
  constexpr int kFrames = 500'000;
  const server::ServiceMetrics metrics;
  const server::FrameRecord frame = counted_frame();
  for (const std::size_t threads : {1U, 2U}) {
    const Clock::time_point begin = Clock::now();
    {
      std::vector<std::jthread> workers;
      for (std::size_t i = 0; i < threads; ++i) {
        workers.emplace_back([&] {
          for (int count = 0; count < kFrames; ++count) metrics.observer()->on_frame(frame);
        });
      }
    }
    fmt::print("metrics, {} thread{}: {:.2f} us a frame\n", threads, threads == 1 ? "" : "s",
               ms_since(begin) * 1000 / kFrames);
  }
}

}  // namespace
}  // namespace segserve::bench

int main(int argc, char** argv) {
  // As in segserve, large buffers are kept. Otherwise every frame would return them to the system and fault them in
  // again.
  mallopt(M_MMAP_THRESHOLD, 1 << 30);
  mallopt(M_TRIM_THRESHOLD, 1 << 30);
  const int count = argc > 1 ? std::max(1, std::atoi(argv[1])) : 50;
  segserve::bench::measure_overhead(count);
  segserve::bench::measure_workers(count);
  segserve::bench::measure_metrics();
}
