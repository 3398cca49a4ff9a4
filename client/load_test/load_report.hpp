// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <map>
#include <string>
#include <string_view>
#include <vector>

#include "client/load_test/percentiles.hpp"
#include "segserve/client/frame.hpp"

namespace segserve::bench {

/// Where the time of a frame goes, in order. "rest" is the time that no other stage accounts for, most of it transport.
/// "total" is the sum, from sending to the decoded result.
inline constexpr std::array<std::string_view, 15> kStages = {
    "client_encode", "client_wait", "queue",    "decode", "voxels",        "normals", "supervoxels", "graph",
    "merging",       "labels",      "segments", "encode", "client_decode", "rest",    "total"};

/// The measurements of one frame of a load test.
struct FrameRecord {
  double latency_ms = 0;     ///< from the intended time of sending to the decoded result
  double since_sent_ms = 0;  ///< from the actual time of sending
  double client_encode_ms = 0;
  double late_ms = 0;  ///< from the intended to the actual time of sending
  std::uint64_t points = 0;
  bool mismatch = false;  ///< labels differ from those of a local run
};

/// The measurements of a load test. Counts are of frames whose intended time was in the measured span.
struct Report {
  double seconds = 0;      ///< the measured span
  double cpu_seconds = 0;  ///< that this process used within it
  std::uint64_t sent = 0;
  std::uint64_t results = 0;
  std::uint64_t repeated = 0;  ///< frames that were sent more than once
  std::uint64_t late = 0;      ///< frames of an open loop that were sent more than 1 ms after their intended time
  std::uint64_t verified = 0, mismatches = 0;
  std::uint64_t points = 0;  ///< in frames with a result
  std::uint64_t bytes_up = 0, bytes_down = 0;
  Samples latency;                                ///< ms, from the intended time of sending
  Samples since_sent;                             ///< ms, from the actual time of sending
  std::array<double, kStages.size()> stage_ms{};  ///< sums over the results
  std::vector<std::uint64_t> results_of_client;   ///< one number for each client
  std::map<std::string, std::uint64_t> errors;    ///< frames without a result, by outcome, status code and reason

  void add(const client::Outcome& outcome, const FrameRecord& record);
  /// Adds the frames of another client; `seconds`, `cpu_seconds` and `results_of_client` stay.
  void add(const Report& other);

  double frames_per_second() const;
  double mpoints_per_second() const;
  double error_percent() const;                   ///< frames without a result; 100 if nothing was sent
  double mean_stage_ms(std::size_t stage) const;  ///< over the frames with a result
  /// The results of the client that got the fewest, as a percentage of the mean of all clients; 0 if there was no
  /// result.
  double least_share_percent() const;
  /// Time of one CPU for each frame with a result.
  double cpu_ms_per_frame() const;
};

}  // namespace segserve::bench
