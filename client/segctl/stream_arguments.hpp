// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "CLI/CLI.hpp"
#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "client/segctl/agent_address.hpp"
#include "client/segctl/codec_flags.hpp"
#include "client/segctl/json_flag.hpp"
#include "client/segctl/option_flags.hpp"
#include "client/segctl/recording_flags.hpp"
#include "client/segctl/server_flags.hpp"
#include "client/segctl/stream_feed.hpp"
#include "segserve/client/stream_options.hpp"

namespace segserve::segctl {

/// The command line of `segctl stream`.
struct StreamArguments {
  std::vector<std::string> inputs;
  bool moving = false;
  std::uint32_t frames = 100;
  std::uint64_t seed = 1;
  std::uint32_t width = 640, height = 480;
  std::optional<double> rate;
  double speed = 1;
  bool loop = false;
  std::optional<double> duration;  ///< seconds
  bool waits = false;
  bool track = false;
  bool fallback_local = false;
  std::string view;
  OptionFlags options;
  CodecFlags codec;
  RecordingFlags recording;
  ServerFlags server;
  std::string html_live;
  bool html_live_for_anyone = false;
  JsonFlag json;
  bool quiet = false;

  void add_to(CLI::App& app);
  /// INVALID_ARGUMENT for flags that do not go together.
  absl::Status check_combination() const;
  absl::StatusOr<FeedOptions> feed_options() const;
  absl::StatusOr<client::StreamOptions> stream_options() const;
  /// Where the page is served; unset if none is asked for.
  absl::StatusOr<std::optional<AgentAddress>> page_address() const;
  /// Names the source of the frames for people: files, a recording or a synthetic scene.
  std::string title() const;
};

}  // namespace segserve::segctl
