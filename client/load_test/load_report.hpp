// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "client/load_test/latencies.hpp"
#include "segserve/client/frame.hpp"

namespace segserve::bench {

/// Where the time of a frame goes, in order. "rest" is the time that no other stage accounts for, most of it transport.
/// "total" is the sum, from the time at which the frame was handed to the client library to the decoded result.
inline constexpr std::array<std::string_view, 15> kStages = {
    "client_encode", "client_wait", "queue",    "decode", "voxels",        "normals", "supervoxels", "graph",
    "merging",       "labels",      "segments", "encode", "client_decode", "rest",    "total"};

/// The measurements of one frame of a load test.
struct FrameRecord {
  double latency_ms = 0;     ///< from the intended time of sending to the decoded result
  double since_sent_ms = 0;  ///< from the time at which its header went to the transport to the decoded result
  double total_ms = 0;       ///< from the time at which it was handed over, before it was encoded
  double client_encode_ms = 0;
  double late_ms = 0;  ///< from the intended time to that at which it was handed over
  std::uint64_t points = 0;
  bool verified = false;
  bool mismatch = false;  ///< labels differ from those of a local run
};

/// The measurements of a load test, or of a part of it. Frames are counted by their intended time, which is in the
/// measured window, and are waited for beyond its end; only what says "finished" counts what happened in the window,
/// also to frames from before.
struct Report {
  double seconds = 0;          ///< the measured window
  std::uint64_t sent = 0;      ///< frames that were due in the window, also those that could not be sent
  std::uint64_t results = 0;   ///< those among them that got a result, sooner or later
  std::uint64_t dropped = 0;   ///< those that made way for newer ones, as StreamOptions::when_behind wants
  std::uint64_t repeated = 0;  ///< frames that were sent more than once
  std::uint64_t hedged = 0;    ///< those among them that two servers had at the same time
  std::uint64_t late = 0;      ///< frames of an open loop that were sent more than 1 ms after their intended time
  std::uint64_t verified = 0, mismatches = 0;
  std::uint64_t points = 0;                                ///< in frames with a result
  std::uint64_t bytes_up = 0, bytes_down = 0;              ///< of frames with a result
  std::uint64_t finished = 0;                              ///< results that came within the window
  std::uint64_t finished_points = 0;                       ///< in their frames
  std::vector<std::uint64_t> finished_of_client;           ///< one number for each client; empty for several runs
  std::optional<double> least_share_of_runs;               ///< of several runs: the lowest least_share_percent
  Latencies latency;                                       ///< from the intended time of sending
  Latencies since_sent;                                    ///< from the actual time of sending
  double encode_ms = 0;                                    ///< that the client spent on encoding all frames
  std::array<double, kStages.size()> stage_ms{};           ///< sums over the results
  std::map<std::string, std::uint64_t> results_of_server;  ///< by the address of the server
  std::map<std::string, std::uint64_t> errors;  ///< frames without a result, by outcome, status code and reason

  void add(const client::Outcome& outcome, const FrameRecord& record);
  /// Counts a frame without any outcome.
  void add_failure(const std::string& why);
  /// A result came within the window.
  void add_finished(std::size_t client, std::uint64_t frame_points);
  /// Adds the frames of another part; `seconds` stays.
  void add(const Report& other);

  /// Results that came within the window, for each of its seconds.
  double frames_per_second() const;
  double mpoints_per_second() const;
  /// Frames that got no result although they should have.
  std::uint64_t failed() const { return sent - results - dropped; }
  double error_percent() const;                   ///< frames without a result; 100 if nothing was sent
  double mean_stage_ms(std::size_t stage) const;  ///< over the frames with a result
  /// The finished results of the client that got the fewest, as a percentage of the mean of all clients of its run; 0
  /// if there was no result.
  double least_share_percent() const;
};

}  // namespace segserve::bench
