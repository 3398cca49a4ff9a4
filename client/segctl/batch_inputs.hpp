#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "proto/wire/codec_message.hpp"
#include "segserve/cloud.hpp"
#include "segserve/options.hpp"

namespace segserve::segctl {

/// One file of many, and where what comes of it goes.
struct BatchInput {
  std::string path;
  std::string cloud_path;    ///< DIR/NAME.pcd: the labelled cloud
  std::string summary_path;  ///< DIR/NAME.json: written last, so that it stands for a complete output
};

/// The files, and the PCD and PLY files of the folders (not of folders in them) by name. INVALID_ARGUMENT if there is
/// none, or two would have the same output; NOT_FOUND for a path that is not there.
absl::StatusOr<std::vector<BatchInput>> batch_inputs(const std::vector<std::string>& paths, const std::string& out_dir);

/// What decides the output besides the points: a hash of all options, the view if one was given, a lossy codec, and
/// whether the segments' statistics are told.
std::string batch_key(const Options& options, const std::optional<View>& view,
                      const std::optional<wire::CodecOptions>& codec, bool segments);

/// True if the output is there, complete, and of a file of the same size segmented with the same key.
bool is_done(const BatchInput& input, const std::string& key);

}  // namespace segserve::segctl
