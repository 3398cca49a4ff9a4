#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "CLI/CLI.hpp"
#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "client/segctl/codec_flags.hpp"
#include "client/segctl/option_flags.hpp"
#include "client/segctl/rgbd_flags.hpp"
#include "client/segctl/scene_output.hpp"
#include "client/segctl/server_flags.hpp"
#include "proto/wire/codec_message.hpp"
#include "segserve/cloud.hpp"
#include "segserve/options.hpp"

namespace segserve::segctl {

/// What is asked of every cloud of `segctl segment`.
struct SegmentRequest {
  Options options;
  std::optional<View> view;                 ///< unset: what the file says
  std::optional<wire::CodecOptions> codec;  ///< unset: as the client library thinks fit
  bool segments = false;                    ///< their statistics
};

/// The command line of `segctl segment`.
struct SegmentArguments {
  std::vector<std::string> scenes;
  std::string out_dir;
  std::size_t parallel = 0;
  OptionFlags options;
  std::string view;
  ServerFlags server;
  RgbdFlags rgbd;
  CodecFlags codec;
  bool local = false;
  bool fallback_local = false;
  std::string request_id;
  SceneOutput scene_output;
  std::string result_path;
  bool segments = false;
  std::string json_path;
  bool quiet = false;

  void add_to(CLI::App& app);
  /// INVALID_ARGUMENT for flags that do not go together.
  absl::Status check_combination() const;
  absl::StatusOr<SegmentRequest> request() const;
};

}  // namespace segserve::segctl
