// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <map>
#include <random>
#include <utility>
#include <vector>

#include "nlohmann/json.hpp"

namespace segserve::bench_report {

/// A load test with latencies of a known distribution.
struct MadeUpRun {
  std::uint64_t seed = 1;
  std::size_t seconds = 30;
  std::size_t rate = 60;    ///< results a second
  double median_ms = 30;    ///< of latencies whose logarithms are normal
  double sigma = 0.25;      ///< of the logarithms, from frame to frame
  double drift = 0;         ///< standard deviation of the logarithms from second to second, and of the rate
  double memory = 0;        ///< of the drift, from one second to the next: the coefficient of an AR(1) process
  double cpu_ms = 3;        ///< of each frame
  double failed_share = 0;  ///< of frames that fail, each by itself
};

/// The JSON of segctl bench for it.
inline nlohmann::ordered_json made_up_json(const MadeUpRun& run) {
  using Json = nlohmann::ordered_json;
  std::mt19937_64 random(run.seed);
  std::normal_distribution<double> normal;
  std::bernoulli_distribution fails(run.failed_share);
  std::map<std::int64_t, std::int64_t> buckets;
  Json timeline = Json::array();
  std::size_t results = 0, failed = 0;
  double level = normal(random);
  for (std::size_t t = 0; t < run.seconds; ++t) {
    level = run.memory * level + std::sqrt(1 - run.memory * run.memory) * normal(random);
    std::vector<double> latencies;
    std::size_t lost = 0;
    const auto frames = std::llround(static_cast<double>(run.rate) * std::exp(-run.drift * level));
    for (long i = 0; i < frames; ++i) {
      const double ms = run.median_ms * std::exp(run.sigma * normal(random) + run.drift * level);
      if (fails(random)) {
        ++lost;
        continue;
      }
      latencies.push_back(ms);
      ++buckets[std::llround(ms * 100) * 10];
    }
    std::ranges::sort(latencies);
    const auto at = [&](double q) -> Json {
      if (latencies.empty()) return {};
      return latencies[static_cast<std::size_t>(std::ceil(q * static_cast<double>(latencies.size()))) - 1];
    };
    const double noise = 1 + 0.02 * normal(random);
    timeline.push_back({{"t", t},
                        {"results", latencies.size()},
                        {"failed", lost},
                        {"p50_ms", at(0.5)},
                        {"p90_ms", at(0.9)},
                        {"p99_ms", at(0.99)},
                        {"max_ms", at(1)},
                        {"client_busy_cpus", noise * run.cpu_ms * static_cast<double>(latencies.size()) / 1000}});
    results += latencies.size();
    failed += lost;
  }
  Json histogram = Json::array();
  for (const auto& [us, count] : buckets) histogram.push_back({us, count});
  const double rate = static_cast<double>(results) / static_cast<double>(run.seconds);
  return {{"format", "segserve-bench-1"},
          {"server", "127.0.0.1:50051"},
          {"clients", 1},
          {"loop", "closed"},
          {"codec", "planar"},
          {"frames", {{"sent", results + failed}, {"results", results}}},
          {"frames_per_s", rate},
          {"achieved_frames_per_s", rate},
          {"mpoints_per_s", 0.3 * rate},
          {"window", {{"measured_s", run.seconds}}},
          {"latency_ms", {{"p50", nullptr}}},
          {"latency_histogram", {{"failed", failed}, {"buckets", std::move(histogram)}}},
          {"client_cpu_ms_per_frame", run.cpu_ms},
          {"timeline", std::move(timeline)}};
}

}  // namespace segserve::bench_report
