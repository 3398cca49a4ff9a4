// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <span>
#include <string>

#include "CLI/CLI.hpp"
#include "absl/status/status.h"
#include "client/segctl/scene_output.hpp"
#include "client/segctl/staged_output.hpp"
#include "segserve/codec/labeled_cloud.hpp"

namespace segserve::segctl {

/// The flag --split: a folder that gets one PCD file a segment. It must outlive the parsing of the command line.
class SplitOutput {
 public:
  void add_to(CLI::App& app);

  bool wanted() const { return !folder_.empty(); }

  /// Announces the folder if the flag was given.
  absl::Status announce(StagedOutput& output) const;

  /// Adds DIR/segment_0001.pcd with the points of label 1, and so on, if the flag was given. Each file has its points
  /// in the order of the cloud, the cloud's view, and what `format` says; points with label 0 are in none. Files of
  /// that kind that are in the folder already and have a higher number are removed, because they are of another result.
  /// `labels` has one entry per point. Warnings of what PCD cannot hold are appended. INVALID_ARGUMENT if there are
  /// more segments than files in a folder make sense.
  absl::Status add(StagedOutput& output, const codec::LabeledCloud& scene, std::span<const std::uint32_t> labels,
                   const SceneOutput& format, std::vector<codec::Warning>& warnings) const;

 private:
  std::string folder_;
};

}  // namespace segserve::segctl
