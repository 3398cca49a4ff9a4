// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "CLI/CLI.hpp"
#include "absl/status/statusor.h"
#include "segserve/codec/rgbd_encode.hpp"

namespace segserve::segctl {

/// The flags --depth, --rgb, --intrinsics and --depth-scale: a pair of images as input. It must outlive the parsing of
/// the command line.
class RgbdFlags {
 public:
  void add_to(CLI::App& app);

  /// Whether any of the flags was given.
  bool given() const;
  /// The name of the input in messages.
  std::string input_name() const { return depth_path_; }

  /// The bytes of the files. INVALID_ARGUMENT if a flag is missing or wrong; other errors as read_input.
  absl::StatusOr<codec::RgbdFiles> load() const;

 private:
  absl::StatusOr<codec::Intrinsics> intrinsics() const;

  std::string depth_path_;
  std::string color_path_;
  std::string intrinsics_;
  double depth_scale_ = 0;
  CLI::Option* depth_scale_option_ = nullptr;
};

}  // namespace segserve::segctl
