#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "absl/status/status.h"
#include "client/segctl/batch_inputs.hpp"
#include "client/segctl/scene_output.hpp"
#include "client/segctl/segment_arguments.hpp"
#include "segserve/client/client.hpp"

namespace segserve::segctl {

/// `segctl segment` on many files.
struct BatchJob {
  std::vector<BatchInput> inputs;
  SegmentRequest request;
  std::size_t parallel = 4;              ///< files at the same time
  std::optional<client::Client> client;  ///< unset: in this process
  std::string server;                    ///< its address, for summaries
  client::StreamOptions stream;
  const SceneOutput* format = nullptr;  ///< encoding and colour of the labelled clouds
  std::string json_path;                ///< one JSON object a file, a line each; "-": standard output; empty: none
  bool quiet = false;
};

/// Segments every file whose output is not there yet. Each output appears whole or not at all, so that a run that was
/// stopped goes on where it was. A file that fails stops no other: errors are listed at the end. The status is OK if
/// no file failed; INVALID_ARGUMENT if it was the fault of files alone.
absl::Status run_batch(const BatchJob& job);

}  // namespace segserve::segctl
