// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <utility>

#include "client/load_test/hdr_histogram.hpp"

namespace segserve::bench {

/// The latencies of frames. A frame that failed counts as infinitely late: otherwise a server that answers one frame
/// in a hundred, and that one fast, would have the best percentiles.
class Latencies {
 public:
  Latencies() = default;
  /// The latencies of frames, as a histogram in microseconds, and the number of further frames that failed.
  Latencies(HdrHistogram histogram, std::uint64_t failed) : histogram_(std::move(histogram)), failed_(failed) {}

  void add(double milliseconds);
  void add_failure() { ++failed_; }
  void add(const Latencies& others);

  std::uint64_t results() const { return histogram_.count(); }
  std::uint64_t failed() const { return failed_; }
  std::uint64_t count() const { return results() + failed(); }

  /// Milliseconds, over the frames with a result; 0 without one.
  double mean() const { return histogram_.mean() / 1000; }
  double max() const { return static_cast<double>(histogram_.max()) / 1000; }
  /// The smallest latency that at least `percent` (0 to 100) of all frames do not exceed, the nearest rank, in
  /// milliseconds; infinity if that is a failed frame; 0 without frames.
  double percentile(double percent) const;
  /// Whether there are enough frames for a percentile to mean something: five of them or more lie beyond it. With
  /// fewer, chance decides what the slowest ones are.
  bool bears(double percent) const;

  /// Microseconds.
  const HdrHistogram& histogram() const { return histogram_; }

 private:
  HdrHistogram histogram_;
  std::uint64_t failed_ = 0;
};

}  // namespace segserve::bench
