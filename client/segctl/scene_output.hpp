// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "CLI/CLI.hpp"
#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "client/segctl/staged_output.hpp"
#include "core/lab/picture/picture.hpp"
#include "segserve/codec/file_format.hpp"
#include "segserve/codec/labeled_cloud.hpp"

namespace segserve::segctl {

/// The flags that ask for a labeled cloud and its pictures: --output, --encoding, --color, --drop-unlabeled, --picture,
/// --plain-picture, --view-from and --legend. It must outlive the parsing of the command line.
class SceneOutput {
 public:
  void add_to(CLI::App& app);

  /// True if a labeled cloud or a picture is wanted, that is, if the points are needed.
  bool wanted() const { return !cloud_path_.empty() || !picture_path_.empty() || !plain_picture_path_.empty(); }

  /// The file that --output names; empty if there is none.
  const std::string& cloud_path() const { return cloud_path_; }
  bool wants_picture() const { return !picture_path_.empty() || !plain_picture_path_.empty(); }

  /// INVALID_ARGUMENT for flags of pictures where there are none.
  absl::Status check_without_pictures() const;

  /// INVALID_ARGUMENT for flags that say how clouds are written if none is. `writes_other_clouds` tells that the
  /// command calls encode_pcd for other files than that of --output.
  absl::Status check_cloud_flags(bool writes_other_clouds) const;

  /// Checks the flags and announces the files.
  absl::Status announce(StagedOutput& output) const;

  /// The labeled cloud as a PCD file, with the encoding, colors and points that the flags ask for. `labels` has one
  /// entry per point. The warnings tell what PCD cannot hold.
  codec::EncodedFile encode_pcd(const codec::LabeledCloud& scene, std::span<const std::uint32_t> labels) const;

  /// Adds the files that the flags ask for. `labels` has one entry per point. The scene has everything that its file
  /// had. What the format of the cloud cannot hold is added to `warnings`.
  absl::Status add(StagedOutput& output, const codec::LabeledCloud& scene, std::span<const std::uint32_t> labels,
                   std::vector<codec::Warning>& warnings) const;

  /// How the flags ask pictures of this scene to be drawn. INVALID_ARGUMENT for a position that is none.
  absl::StatusOr<picture::RenderOptions> render_options(const codec::LabeledCloud& scene) const;

  /// Names the flags that decide how encode_pcd writes a cloud; empty for the defaults.
  std::string format_key() const;

 private:
  absl::Status check_format() const;
  absl::StatusOr<codec::EncodedFile> encode(const codec::LabeledCloud& scene, std::span<const std::uint32_t> labels,
                                            codec::FileFormat format) const;

  std::string cloud_path_;
  std::string encoding_ = "binary";
  std::string color_ = "own";
  bool drop_unlabeled_ = false;
  std::vector<const CLI::Option*> cloud_options_;  ///< those of check_cloud_flags
  std::string picture_path_;
  std::string plain_picture_path_;
  std::string view_from_;
  bool legend_ = false;
};

/// Appends what a file that is written does not hold, with its path in front.
void append_warnings(const std::string& path, const std::vector<codec::Warning>& of_file,
                     std::vector<codec::Warning>& warnings);

}  // namespace segserve::segctl
