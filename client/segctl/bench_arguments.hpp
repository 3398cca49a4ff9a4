// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "CLI/CLI.hpp"
#include "absl/status/statusor.h"
#include "client/load_test/objective.hpp"
#include "client/load_test/plan.hpp"
#include "client/segctl/bench_html.hpp"
#include "client/segctl/codec_flags.hpp"
#include "client/segctl/json_flag.hpp"
#include "client/segctl/option_flags.hpp"
#include "client/segctl/recording_flags.hpp"
#include "client/segctl/sequence.hpp"
#include "client/segctl/server_flags.hpp"

namespace segserve::segctl {

/// The command line of `segctl bench`.
struct BenchArguments {
  OptionFlags options;
  ServerFlags server;
  std::string clients = "1";
  std::optional<std::size_t> in_flight;
  double hedge_after_ms = 0;
  bool drop_oldest = false;
  double rate = 0;
  std::string steps, ramp;
  std::string search, until_stable, soak;
  double interval_s = 0;
  std::string metrics, metrics_listen, fault;
  std::string agents, agent, agent_token_file;
  bool agent_for_anyone = false;
  std::string arrivals = "constant";
  double duration_s = 10;
  double warm_up_s = 1;
  std::uint64_t seed = 1;
  std::vector<std::string> inputs;
  RecordingFlags recording;
  double speed = 1;
  CLI::Option* speed_flag = nullptr;
  std::string size = "640x480";
  std::size_t scenes = 4;
  CodecFlags codec;
  bool encoded_beforehand = false;
  std::optional<double> drain_s;
  bool verify = false;
  std::vector<std::string> outputs{"labels"};
  std::vector<std::string> objectives;
  JsonFlag json;
  BenchHtmlFlag html;
  std::string csv, hdr_log;  ///< files to write

  void add_to(CLI::App& app);
  bool has_recording() const { return inputs.size() == 1 && is_recording_file(inputs.front()); }
  /// Whether the input is a folder that tells the times of its clouds.
  bool has_sequence() const { return inputs.size() == 1 && has_capture_times(inputs.front()); }
  /// Whether frames come at the times at which they were recorded.
  bool replays() const { return (has_recording() || has_sequence()) && !has_rate() && search.empty(); }

  /// The load that the flags describe. INVALID_ARGUMENT if they do not fit together.
  absl::StatusOr<bench::LoadPlan> plan() const;
  absl::StatusOr<std::vector<bench::Objective>> parsed_objectives() const;
  /// The secret of --agent-token-file; empty without it. Errors as of credentials::read_shared_secret.
  absl::StatusOr<std::string> agent_secret() const;
  bool soaks() const { return !soak.empty(); }

 private:
  bool has_rate() const { return rate > 0 || !steps.empty() || !ramp.empty(); }
  void add_load_flags(CLI::App& app);
  void add_schedule_flags(CLI::App& app);
  void add_fault_flags(CLI::App& app);
  void add_frame_flags(CLI::App& app);
  void add_result_flags(CLI::App& app);
  /// The rates over time.
  absl::Status add_schedule(bench::LoadPlan& plan) const;
  absl::Status add_stream_options(bench::LoadOptions& load) const;
};

}  // namespace segserve::segctl
