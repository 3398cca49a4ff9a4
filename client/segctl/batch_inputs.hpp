// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "absl/status/statusor.h"

namespace segserve::segctl {

/// One file of a batch, and where its outputs go.
struct BatchInput {
  std::string path;
  std::string cloud_path;    ///< DIR/NAME.pcd: the labeled cloud. For NAME see output_names. Empty: none is written.
  std::string summary_path;  ///< DIR/NAME.json: written last, so that it stands for a complete output.
};

/// The clouds in a folder, by their names. Prints a warning of files that cannot be read in a folder. UNAVAILABLE if
/// the folder cannot be read.
absl::StatusOr<std::vector<std::string>> cloud_files_in(const std::string& folder);

/// The given files, and the files of clouds (codec::is_cloud_file) in the given folders (not in folders within them),
/// sorted by name within each folder. A file that is given twice is taken once. Without `out_dir` nothing is written.
/// INVALID_ARGUMENT if there is none, or if an output would overwrite a file or another output; NOT_FOUND for a path
/// that does not exist.
absl::StatusOr<std::vector<BatchInput>> batch_inputs(const std::vector<std::string>& paths, const std::string& out_dir);

/// The counts in the summary of an earlier run.
struct DoneBefore {
  std::size_t points = 0;
  std::uint32_t segments = 0;
};

/// Set if the output is there, complete, and of a file of the same name and size that was segmented with the same key.
std::optional<DoneBefore> done_before(const BatchInput& input, const std::string& key);

}  // namespace segserve::segctl
