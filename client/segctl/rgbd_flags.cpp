// SPDX-License-Identifier: Apache-2.0
#include "client/segctl/rgbd_flags.hpp"

#include "client/segctl/input_file.hpp"
#include "client/segctl/number_list.hpp"
#include "core/base/status_macros.hpp"
#include "core/base/status_text.hpp"
#include "fmt/format.h"

namespace segserve::segctl {

void RgbdFlags::add_to(CLI::App& app) {
  depth_scale_ = codec::RgbdOptions{}.depth_scale;
  app.add_option("--depth", depth_path_, "instead of SCENE: the depth image of an RGB-D camera, a 16-bit gray PNG")
      ->type_name("PNG")
      ->group("RGB-D images");
  app.add_option("--rgb", color_path_, "the color image, PNG or JPEG, of the same size and aligned with the depth")
      ->type_name("IMAGE")
      ->group("RGB-D images");
  app.add_option("--intrinsics", intrinsics_,
                 "focal lengths and center of the camera in pixels; the center of the first pixel is 0,0")
      ->type_name("FX,FY,CX,CY")
      ->group("RGB-D images");
  depth_scale_option_ = app.add_option("--depth-scale", depth_scale_, "meters a unit of depth")
                            ->type_name("METERS")
                            ->capture_default_str()
                            ->group("RGB-D images");
}

bool RgbdFlags::given() const {
  return !depth_path_.empty() || !color_path_.empty() || !intrinsics_.empty() || depth_scale_option_->count() > 0;
}

absl::StatusOr<codec::Intrinsics> RgbdFlags::intrinsics() const {
  const auto numbers = parse_numbers<double, 4>(intrinsics_);
  if (!numbers) {
    return absl::InvalidArgumentError(
        fmt::format("--intrinsics {}: must be FX,FY,CX,CY, four numbers in pixels", intrinsics_));
  }
  const codec::Intrinsics camera{.fx = (*numbers)[0], .fy = (*numbers)[1], .cx = (*numbers)[2], .cy = (*numbers)[3]};
  const absl::Status status = codec::check_intrinsics(camera);
  if (!status.ok()) return absl::InvalidArgumentError(fmt::format("--intrinsics: {}", message_of(status)));
  return camera;
}

absl::StatusOr<codec::RgbdFiles> RgbdFlags::load() const {
  if (depth_path_.empty() || intrinsics_.empty()) {
    return absl::InvalidArgumentError("RGB-D images need --depth and --intrinsics FX,FY,CX,CY (--rgb may be left out)");
  }
  codec::RgbdFiles files;
  ASSIGN_OR_RETURN(files.intrinsics, intrinsics());
  if (const absl::Status status = codec::check_depth_scale(depth_scale_); !status.ok()) {
    return absl::InvalidArgumentError(fmt::format("--depth-scale: {}", message_of(status)));
  }
  files.depth_scale = depth_scale_;
  ASSIGN_OR_RETURN(files.depth, read_input(depth_path_));
  if (!color_path_.empty()) {
    ASSIGN_OR_RETURN(files.color, read_input(color_path_));
  }
  return files;
}

}  // namespace segserve::segctl
