// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "CLI/CLI.hpp"

namespace segserve::segctl {

/// The flags --topic, --color-topic, --camera-info-topic and --only-topic, for recordings. It must outlive the parsing
/// of the command line.
struct RecordingFlags {
  std::string topic, color_topic, camera_info_topic;
  bool only_topic = false;

  static constexpr const char* kGroup = "Recordings";

  /// Adds the flags that choose topics.
  void add_to(CLI::App& app);
  /// Adds --only-topic.
  void add_output_to(CLI::App& app);
  bool given() const { return only_topic || !topic.empty() || !color_topic.empty() || !camera_info_topic.empty(); }
};

/// Whether the path leads to a recording, by the first bytes of the file. False for "-" and for what cannot be read.
bool is_recording_file(const std::string& path);

}  // namespace segserve::segctl
