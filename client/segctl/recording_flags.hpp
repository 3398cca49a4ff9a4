// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "CLI/CLI.hpp"

namespace segserve::segctl {

/// The flags --topic and --only-topic, for recordings. It must outlive the parsing of the command line.
struct RecordingFlags {
  std::string topic;
  bool only_topic = false;

  void add_to(CLI::App& app);
  bool given() const { return !topic.empty() || only_topic; }
};

/// Whether the path leads to a recording, by the first bytes of the file. False for "-" and for what cannot be read.
bool is_recording_file(const std::string& path);

}  // namespace segserve::segctl
