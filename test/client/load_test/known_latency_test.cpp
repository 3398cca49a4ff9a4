// SPDX-License-Identifier: Apache-2.0
// The load test measures a server whose latencies are known.
#include <algorithm>
#include <atomic>
#include <chrono>
#include <cmath>
#include <cstddef>
#include <functional>
#include <memory>
#include <thread>
#include <vector>

#include "client/load_test/findings.hpp"
#include "client/load_test/load.hpp"
#include "client/load_test/plan.hpp"
#include "core/base/mutex.hpp"
#include "core/lab/synth/scene.hpp"
#include "gmock/gmock.h"
#include "test/client/fake_server.hpp"

namespace segserve::bench {
namespace {

using client::Clock;
using std::chrono::milliseconds;

/// A server that holds each frame for a time that the test chooses.
class HoldingServer {
 public:
  /// Gets the number of the frame, from 0, and the milliseconds since the first one came.
  explicit HoldingServer(std::function<double(std::size_t, double)> hold_ms) {
    server_.before_answer = [this, hold_ms = std::move(hold_ms)] {
      const auto came = Clock::now();
      double since_first = 0;
      std::size_t number = 0;
      {
        const MutexLock lock(mutex_);
        if (frames_ == 0) first_ = came;
        since_first = std::chrono::duration<double, std::milli>(came - first_).count();
        number = frames_++;
      }
      std::this_thread::sleep_for(std::chrono::duration<double, std::milli>(hold_ms(number, since_first)));
      const MutexLock lock(mutex_);
      held_ms_.push_back(std::chrono::duration<double, std::milli>(Clock::now() - came).count());
    };
  }

  const std::string& address() const { return server_.address(); }
  /// A percentile of the times for which frames were really held on this machine.
  double held_percentile(double percent) {
    const MutexLock lock(mutex_);
    std::ranges::sort(held_ms_);
    const auto rank = static_cast<std::size_t>(std::ceil(percent / 100 * static_cast<double>(held_ms_.size())));
    return held_ms_.at(std::max<std::size_t>(rank, 1) - 1);
  }
  double held_mean() {
    const MutexLock lock(mutex_);
    double sum = 0;
    for (const double held : held_ms_) sum += held;
    return sum / static_cast<double>(held_ms_.size());
  }

 private:
  Mutex mutex_;
  std::size_t frames_ ABSL_GUARDED_BY(mutex_) = 0;
  Clock::time_point first_ ABSL_GUARDED_BY(mutex_);
  std::vector<double> held_ms_ ABSL_GUARDED_BY(mutex_);
  client::FakeServer server_;
};

FrameSource tiny_frames() {
  synth::SceneOptions options;
  options.width = 24;
  options.height = 18;
  FrameSource source;
  source.clouds = {std::make_shared<const Cloud>(synth::make_tabletop(options).value().cloud)};
  source.encodings = {{.name = "planar", .encode = [](std::shared_ptr<const Cloud> cloud) {
                         return client::cloud_payload(std::move(cloud));
                       }}};
  return source;
}

/// An open loop without a warm-up.
LoadOptions load_at(const HoldingServer& server, double rate, double seconds, std::size_t clients) {
  LoadOptions options;
  options.client.address = server.address();
  options.stream.outputs = {.labels = true};
  options.stream.max_in_flight = 8;
  options.stream.max_waiting = 1024;
  options.clients = clients;
  options.rates = {{rate, rate, seconds}};
  options.warm_up = milliseconds(0);
  options.duration = milliseconds(static_cast<int>(1000 * seconds));
  options.encoded_beforehand = true;
  options.interval_s = 0.25;
  return options;
}

LoadResult run(const LoadOptions& options) {
  const FrameSource source = tiny_frames();
  return run_load(options, source, prepare_frames(options, source).value(), {}).value();
}

/// The time, ms, that this machine needs for a frame that the server does not hold: 2, or more if it is slow or busy.
double compute_ms() {
  constexpr double kUsual = 2, kMost = 25;
  HoldingServer server([](std::size_t, double) { return 0.0; });
  return std::clamp(run(load_at(server, 16, 1, 8)).total.latency.percentile(99), kUsual, kMost);
}

/// Whether a percentile is that of the server's own times, but for what is computed beside.
bool within_2_percent(double measured, double truth, double compute) {
  return measured >= 0.98 * truth && measured <= 1.02 * truth + compute;
}

/// Runs the load against such a server, and tells whether the percentiles are right. A machine that does other things
/// may hold up a frame on its way, so there are three tries.
testing::AssertionResult measures_well(const std::function<double(std::size_t, double)>& hold_ms, double seconds,
                                       std::initializer_list<double> percentiles) {
  std::string faults;
  for (int i = 0; i < 3; ++i) {
    const double compute = compute_ms();
    HoldingServer server(hold_ms);
    const LoadResult result = run(load_at(server, 16, seconds, 8));
    if (result.total.results != 16 * seconds) return testing::AssertionFailure() << result.total.results << " results";
    const std::size_t before = faults.size();
    for (const double percent : percentiles) {
      const double measured = result.total.latency.percentile(percent), truth = server.held_percentile(percent);
      if (within_2_percent(measured, truth, compute)) continue;
      faults += fmt::format("p{}: {} for {} and {} of computing; ", percent, measured, truth, compute);
    }
    if (faults.size() == before) return testing::AssertionSuccess();
  }
  return testing::AssertionFailure() << faults;
}

TEST(KnownLatency, AFixedOneIsEachPercentile) {
  EXPECT_TRUE(measures_well([](std::size_t, double) { return 200.0; }, 3, {50, 90, 99}));
}

TEST(KnownLatency, BothModesAreSeen) {
  // One frame in eight is slow.
  EXPECT_TRUE(
      measures_well([](std::size_t number, double) { return number % 8 == 7 ? 400.0 : 100.0; }, 4, {50, 85, 90, 99}));
}

TEST(KnownLatency, AStallShowsInTheLatencyFromTheIntendedTime) {
  // From 1 s on, one frame is held for 2 s, and with it all that are due until then.
  std::atomic<bool> stalled{false};
  HoldingServer server([&stalled](std::size_t, double since_first) {
    return since_first > 1000 && !stalled.exchange(true) ? 2000.0 : 2.0;
  });
  const LoadResult result = run(load_at(server, 20, 5, 1));
  EXPECT_EQ(result.total.results, 100U);
  // The stall meets 40 of 100 frames. They wait for between 0 and 2 s: 20 for more than 1 s, 10 for more than 1.5 s.
  EXPECT_NEAR(result.total.latency.percentile(80), 1000, 150);
  EXPECT_NEAR(result.total.latency.percentile(90), 1500, 150);
  EXPECT_NEAR(result.total.latency.max(), 2000, 150);
  // Frames that waited in the client were not sent yet: their time since then says nothing of the stall.
  EXPECT_LT(result.total.since_sent.percentile(90), 500);
}

TEST(KnownLatency, OneThatGrowsIsSaidToBeUnstable) {
  HoldingServer server([](std::size_t, double since_first) { return 50 + since_first / 20; });
  const LoadOptions options = load_at(server, 40, 3, 16);
  const LoadResult result = run(options);
  EXPECT_GE(result.total.latency.percentile(90), 0.98 * server.held_percentile(90));
  std::vector<std::string> codes;
  for (const Finding& finding : findings(options, result)) codes.push_back(finding.code);
  EXPECT_THAT(codes, testing::Contains("UNSTABLE"));
}

TEST(KnownLatency, ASearchFindsTheCapacity) {
  // One frame at a time, 25 ms each: 40 frames/s, and no more.
  HoldingServer server([](std::size_t, double) { return 25.0; });
  LoadPlan plan;
  plan.load = load_at(server, 1, 1.2, 1);
  plan.load.warm_up = milliseconds(200);
  plan.client_counts = {1};
  plan.search = parse_objective("p99<60ms").value();
  const auto found = run_plan(plan, {}, local_runner(plan, tiny_frames()).value(), {});
  ASSERT_TRUE(found.ok()) << found.status();
  ASSERT_TRUE(found->capacity);
  const double truth = 1000 / (server.held_mean() + 1);  // it computes for about 1 ms beside
  EXPECT_NEAR(found->capacity->low, truth, 0.05 * truth);
  EXPECT_LE(found->capacity->high, found->capacity->low * 1.031);
  EXPECT_EQ(found->points.size(), found->capacity->tries.size());
}

TEST(KnownLatency, AServerThatSaysNothingDoesNotHoldUpTheEnd) {
  HoldingServer server([](std::size_t, double) { return 3000.0; });
  LoadOptions options = load_at(server, 100, 0.5, 2);
  options.drain = milliseconds(300);
  const auto began = Clock::now();
  const LoadResult result = run(options);
  EXPECT_LT(Clock::now() - began, std::chrono::seconds(5));
  EXPECT_EQ(result.total.results, 0U);
  EXPECT_EQ(result.total.sent, 50U);
  EXPECT_EQ(result.total.errors.at("UNFINISHED"), 50U);
  EXPECT_TRUE(std::isinf(result.total.latency.percentile(50)));
}

}  // namespace
}  // namespace segserve::bench
