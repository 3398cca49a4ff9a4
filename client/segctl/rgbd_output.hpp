// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "CLI/CLI.hpp"
#include "absl/status/status.h"
#include "client/segctl/staged_output.hpp"
#include "segserve/cloud.hpp"
#include "segserve/codec/rgbd.hpp"

namespace segserve::segctl {

/// The flags --depth, --rgb and --depth-scale: a pair of images as output. It must outlive the parsing of the command
/// line.
class RgbdOutput {
 public:
  void add_to(CLI::App& app, const std::string& group);

  bool wanted() const { return !depth_path_.empty(); }
  double depth_scale() const { return depth_scale_; }

  /// Checks the flags and announces the files.
  absl::Status announce(StagedOutput& output) const;

  /// Adds the images of an organized cloud that `camera` sees. INVALID_ARGUMENT if a depth does not fit into 16 bits.
  absl::Status add(StagedOutput& output, const CloudView& cloud, const codec::Intrinsics& camera) const;

  /// The flags by which segctl segment reads the images.
  std::string as_input_flags(const codec::Intrinsics& camera) const;

 private:
  std::string depth_path_;
  std::string color_path_;
  double depth_scale_ = 0;
};

}  // namespace segserve::segctl
