// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "CLI/CLI.hpp"
#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "client/segctl/input_file.hpp"
#include "segserve/codec/rgbd_encode.hpp"

namespace segserve::segctl {

/// The flags --depth, --rgb, --intrinsics, --rgb-intrinsics, --depth-scale and --depth-unit: a pair of images as input.
/// It must outlive the parsing of the command line.
class RgbdFlags {
 public:
  void add_to(CLI::App& app);

  /// Whether any of the flags was given.
  bool given() const;
  /// The name of the input in messages.
  /// The paths of the images that were named.
  std::vector<std::string> paths() const;
  std::string input_name() const { return segctl::input_name(depth_path_); }

  /// The bytes of the files. TIFF becomes PGM, PFM or PPM, which servers read. INVALID_ARGUMENT if a flag is missing or
  /// wrong, or a TIFF is broken; other errors as read_input.
  absl::StatusOr<codec::RgbdFiles> load() const;

  /// An error of codec::decode_rgbd, here or in a server, with the name of the file before it if it is about one of the
  /// images.
  absl::Status with_file_name(const absl::Status& status) const;

 private:
  absl::StatusOr<double> depth_scale(std::string_view depth) const;

  std::string depth_path_;
  std::string color_path_;
  std::string intrinsics_;
  std::string color_intrinsics_;
  std::string depth_unit_;
  double depth_scale_ = 0;
  CLI::Option* depth_scale_option_ = nullptr;
};

}  // namespace segserve::segctl
