// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "CLI/CLI.hpp"
#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "client/segctl/codec_flags.hpp"
#include "client/segctl/dendrogram_flag.hpp"
#include "client/segctl/json_flag.hpp"
#include "client/segctl/option_flags.hpp"
#include "client/segctl/prompt_flags.hpp"
#include "client/segctl/recording_flags.hpp"
#include "client/segctl/rgbd_flags.hpp"
#include "client/segctl/scene_output.hpp"
#include "client/segctl/server_flags.hpp"
#include "client/segctl/split_output.hpp"
#include "client/segctl/trace_flag.hpp"
#include "client/segctl/track_flags.hpp"
#include "client/segctl/unit_flag.hpp"
#include "proto/wire/codec_message.hpp"
#include "segserve/cloud.hpp"
#include "segserve/codec/read_options.hpp"
#include "segserve/options.hpp"

namespace segserve::segctl {

/// The part of the command line that applies to every cloud.
struct SegmentRequest {
  Options options;
  std::optional<View> view;                 ///< Unset: as the file says.
  std::optional<codec::LengthUnit> unit;    ///< Unset: as the file says, or else meters.
  std::optional<wire::CodecOptions> codec;  ///< Unset: the client library chooses.
  bool segments = false;                    ///< Whether the statistics of the segments are wanted.
  std::optional<Prompts> prompts;           ///< In the coordinates and unit of the file.
  std::string traceparent;                  ///< Of every call; may be empty.
  bool keep_everything = false;             ///< Whether the cloud will be written again.

  codec::ReadOptions read_options() const { return {.view = view, .unit = unit, .keep_everything = keep_everything}; }
};

/// The command line of `segctl segment`.
struct SegmentArguments {
  std::vector<std::string> scenes;
  std::string cameras;  ///< The file that tells the clouds of several cameras and their poses; may be empty.
  std::string out_dir;
  std::size_t parallel = 0;  ///< 0: 4, or one per CPU with `local`.
  OptionFlags options;
  PromptFlags prompts;
  std::string view;
  UnitFlag unit;
  ServerFlags server;
  RgbdFlags rgbd;
  RecordingFlags recording;
  CodecFlags codec;
  bool local = false;
  bool fallback_local = false;
  std::string request_id;
  TraceFlag trace;
  SceneOutput scene_output;
  SplitOutput split_output;
  DendrogramFlag dendrogram;
  std::string contact_sheet;  ///< where to; empty: none is asked for
  TrackFlags track;
  std::string result_path;
  bool segments = false;
  JsonFlag json;
  bool quiet = false;

  void add_to(CLI::App& app);
  /// INVALID_ARGUMENT for flags that do not go together.
  absl::Status check_combination() const;
  /// Whether many clouds are segmented, one by one.
  bool many() const { return (!out_dir.empty() || !contact_sheet.empty()) && cameras.empty(); }
  absl::StatusOr<SegmentRequest> request() const;

 private:
  absl::Status check_cameras() const;
};

}  // namespace segserve::segctl
