// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "absl/status/status.h"
#include "client/segctl/batch_inputs.hpp"
#include "client/segctl/json_flag.hpp"
#include "client/segctl/scene_output.hpp"
#include "client/segctl/segment_arguments.hpp"
#include "client/segctl/sheet_collector.hpp"
#include "segserve/client/client.hpp"

namespace segserve::segctl {

/// `segctl segment` on many files.
struct BatchJob {
  std::vector<BatchInput> inputs;
  SegmentRequest request;
  std::size_t parallel = 4;              ///< How many files are segmented at the same time.
  std::optional<client::Client> client;  ///< Unset: everything is segmented in this process.
  std::string server;                    ///< Its address, for summaries.
  client::StreamOptions stream;
  const SceneOutput* format = nullptr;  ///< Encoding and colors of the labeled clouds; not null.
  const JsonFlag* json = nullptr;       ///< Where one JSON object a file goes, each on a line; not null.
  std::string sheet_path;               ///< Where the contact sheet goes; empty: nowhere.
  SheetCollector* sheet = nullptr;      ///< Collects its pictures; null without one.
  bool quiet = false;
};

/// Segments every file whose output is not there yet. Each output appears whole or not at all, so that a run that was
/// stopped goes on where it was. A file that fails stops no other: errors are listed at the end. The status is OK if
/// no file failed, and INVALID_ARGUMENT if every failure was the fault of the file. SIGINT and SIGTERM stop the batch
/// (CANCELLED), and so does an outage of all servers (UNAVAILABLE, StreamOptions::longest_outage); files that were not
/// done then are neither failed nor half-written.
absl::Status run_batch(const BatchJob& job);

}  // namespace segserve::segctl
