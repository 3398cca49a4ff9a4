#pragma once

#include <cstdint>
#include <span>
#include <string>

#include "CLI/CLI.hpp"
#include "absl/status/status.h"
#include "client/segctl/staged_output.hpp"
#include "segserve/cloud.hpp"

namespace segserve::segctl {

/// The flags -o, --encoding, --color and --picture, and what they ask for. Must outlive the parsing
/// of the command line.
class SceneOutput {
 public:
  /// `with_color` adds --color, which needs segments.
  void add_to(CLI::App& app, bool with_color);

  /// True if a labelled cloud or a picture is wanted, that is, if the points are needed.
  bool wanted() const { return !cloud_path_.empty() || !picture_path_.empty(); }

  /// Checks the flags and announces the files.
  absl::Status announce(StagedOutput& output) const;

  /// The labelled cloud as a PCD file, with the encoding and colour that the flags say.
  std::string encode_pcd(const CloudView& cloud, std::span<const std::uint32_t> labels) const;

  /// Encodes cloud and picture; `labels` has one entry per point.
  void add(StagedOutput& output, const CloudView& cloud, std::span<const std::uint32_t> labels) const;

 private:
  std::string encode(const CloudView& cloud, std::span<const std::uint32_t> labels) const;

  std::string cloud_path_;
  std::string picture_path_;
  std::string encoding_ = "binary";
  std::string color_ = "own";
};

}  // namespace segserve::segctl
