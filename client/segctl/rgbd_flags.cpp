// SPDX-License-Identifier: Apache-2.0
#include "client/segctl/rgbd_flags.hpp"

#include "client/segctl/input_file.hpp"
#include "client/segctl/tiff_image.hpp"
#include "core/base/status_macros.hpp"
#include "core/base/status_text.hpp"
#include "fmt/format.h"
#include "proto/text/number_list.hpp"

namespace segserve::segctl {
namespace {

constexpr const char* kGroup = "RGB-D images";

absl::StatusOr<codec::Intrinsics> parse_intrinsics(std::string_view flag, const std::string& text) {
  const auto numbers = text::parse_numbers<double, 4>(text);
  if (!numbers) {
    return absl::InvalidArgumentError(fmt::format("{} {}: must be FX,FY,CX,CY, four numbers in pixels", flag, text));
  }
  const codec::Intrinsics camera{.fx = (*numbers)[0], .fy = (*numbers)[1], .cx = (*numbers)[2], .cy = (*numbers)[3]};
  const absl::Status status = codec::check_intrinsics(camera);
  if (!status.ok()) return with_prefix(flag, status);
  return camera;
}

/// Reads an image; one that is a TIFF becomes what `convert` makes of it.
template <typename Convert>
absl::StatusOr<std::string> read_image(const std::string& path, Convert convert) {
  ASSIGN_OR_RETURN(std::string bytes, read_input(path));
  if (!is_tiff(bytes)) return bytes;
  auto converted = convert(bytes);
  if (!converted.ok()) return with_prefix(input_name(path), converted.status());
  return converted;
}

}  // namespace

void RgbdFlags::add_to(CLI::App& app) {
  app.add_option("--depth", depth_path_, "instead of SCENE: an RGB-D camera's depth image, PNG, PGM, TIFF, PFM or NPY")
      ->type_name("IMAGE")
      ->group(kGroup);
  app.add_option("--rgb", color_path_, "the color image, PNG, JPEG, PPM or TIFF, aligned with the depth")
      ->type_name("IMAGE")
      ->group(kGroup);
  app.add_option("--intrinsics", intrinsics_,
                 "focal lengths and center in pixels; the center of the first pixel is 0,0")
      ->type_name("FX,FY,CX,CY")
      ->group(kGroup);
  app.add_option("--rgb-intrinsics", color_intrinsics_,
                 "those of the color image, in its pixels; default: both images show the same part of the scene, maybe "
                 "in other resolutions")
      ->type_name("FX,FY,CX,CY")
      ->group(kGroup);
  depth_scale_option_ =
      app.add_option("--depth-scale", depth_scale_,
                     "meters a unit of depth; 0 and 65535 are no depth; default: 0.001, and 1 for floats")
          ->type_name("METERS")
          ->group(kGroup);
  app.add_option("--depth-unit", depth_unit_, "instead of --depth-scale: mm or m")
      ->type_name("UNIT")
      ->check(CLI::IsMember({"mm", "m"}))
      ->excludes(depth_scale_option_)
      ->group(kGroup);
}

bool RgbdFlags::given() const {
  return !depth_path_.empty() || !color_path_.empty() || !intrinsics_.empty() || !color_intrinsics_.empty() ||
         !depth_unit_.empty() || depth_scale_option_->count() > 0;
}

std::vector<std::string> RgbdFlags::paths() const {
  std::vector<std::string> paths;
  for (const std::string& path : {depth_path_, color_path_}) {
    if (!path.empty()) paths.push_back(path);
  }
  return paths;
}

absl::StatusOr<double> RgbdFlags::depth_scale(std::string_view depth) const {
  if (!depth_unit_.empty()) return depth_unit_ == "mm" ? 0.001 : 1;
  if (depth_scale_option_->count() == 0) {
    // Whoever decodes the image says what is wrong with an unknown format.
    return codec::depth_format(depth).value_or(codec::DepthFormat{}).usual_scale();
  }
  if (const absl::Status status = codec::check_depth_scale(depth_scale_); !status.ok()) {
    return with_prefix("--depth-scale", status);
  }
  return depth_scale_;
}

absl::StatusOr<codec::RgbdFiles> RgbdFlags::load() const {
  if (depth_path_.empty() || intrinsics_.empty()) {
    return absl::InvalidArgumentError("RGB-D images need --depth and --intrinsics FX,FY,CX,CY (--rgb may be left out)");
  }
  if (color_path_.empty() && !color_intrinsics_.empty()) {
    return absl::InvalidArgumentError("--rgb-intrinsics needs --rgb");
  }
  codec::RgbdFiles files;
  ASSIGN_OR_RETURN(files.intrinsics, parse_intrinsics("--intrinsics", intrinsics_));
  if (!color_intrinsics_.empty()) {
    ASSIGN_OR_RETURN(files.color_intrinsics, parse_intrinsics("--rgb-intrinsics", color_intrinsics_));
  }
  RETURN_IF_ERROR(depth_scale("").status());
  ASSIGN_OR_RETURN(files.depth, read_image(depth_path_, depth_from_tiff));
  ASSIGN_OR_RETURN(files.depth_scale, depth_scale(files.depth));
  if (!color_path_.empty()) {
    ASSIGN_OR_RETURN(files.color, read_image(color_path_, color_from_tiff));
    // To a decoder, an image without bytes is none.
    if (files.color.empty()) {
      return absl::InvalidArgumentError(fmt::format("{} is empty", segctl::input_name(color_path_)));
    }
  }
  return files;
}

absl::Status RgbdFlags::with_file_name(const absl::Status& status) const {
  const std::string message = message_of(status);
  if (message.starts_with("depth: ")) return with_prefix(segctl::input_name(depth_path_), status);
  if (message.starts_with("color: ")) return with_prefix(segctl::input_name(color_path_), status);
  return status;
}

}  // namespace segserve::segctl
