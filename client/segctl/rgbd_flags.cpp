#include "client/segctl/rgbd_flags.hpp"

#include <array>
#include <charconv>
#include <utility>

#include "client/segctl/input_file.hpp"
#include "fmt/format.h"

namespace segserve::segctl {

void RgbdFlags::add_to(CLI::App& app) {
  depth_scale_ = codec::RgbdOptions{}.depth_scale;
  app.add_option("--depth", depth_path_, "instead of SCENE: the depth image of an RGB-D camera, 16-bit grey PNG")
      ->type_name("PNG")
      ->group("RGB-D images");
  app.add_option("--rgb", color_path_, "the colour image of the same size, aligned with the depth; PNG or JPEG")
      ->type_name("IMAGE")
      ->group("RGB-D images");
  app.add_option("--intrinsics", intrinsics_,
                 "the camera: focal lengths and centre in pixels; the first pixel's centre is 0,0")
      ->type_name("FX,FY,CX,CY")
      ->group("RGB-D images");
  depth_scale_option_ = app.add_option("--depth-scale", depth_scale_, "metres a unit of depth")
                            ->type_name("METRES")
                            ->capture_default_str()
                            ->group("RGB-D images");
}

bool RgbdFlags::given() const {
  return !depth_path_.empty() || !color_path_.empty() || !intrinsics_.empty() || depth_scale_option_->count() > 0;
}

absl::StatusOr<codec::Intrinsics> RgbdFlags::intrinsics() const {
  std::array<double, 4> numbers{};
  const char* at = intrinsics_.data();
  const char* const end = at + intrinsics_.size();
  bool good = true;
  for (std::size_t i = 0; i < numbers.size() && good; ++i) {
    if (i > 0) good = at != end && *at++ == ',';
    const auto [rest, error] = std::from_chars(at, end, numbers[i]);
    good = good && error == std::errc{};
    at = rest;
  }
  if (!good || at != end) {
    return absl::InvalidArgumentError(
        fmt::format("--intrinsics {}: must be FX,FY,CX,CY, four numbers in pixels", intrinsics_));
  }
  const codec::Intrinsics camera{.fx = numbers[0], .fy = numbers[1], .cx = numbers[2], .cy = numbers[3]};
  const absl::Status status = codec::check_intrinsics(camera);
  if (!status.ok()) return absl::InvalidArgumentError(fmt::format("--intrinsics: {}", std::string(status.message())));
  return camera;
}

absl::StatusOr<codec::RgbdFiles> RgbdFlags::load() const {
  if (depth_path_.empty() || intrinsics_.empty()) {
    return absl::InvalidArgumentError("RGB-D images need --depth and --intrinsics FX,FY,CX,CY (--rgb may be left out)");
  }
  codec::RgbdFiles files;
  const auto camera = intrinsics();
  if (!camera.ok()) return camera.status();
  files.intrinsics = *camera;
  if (const absl::Status status = codec::check_depth_scale(depth_scale_); !status.ok()) {
    return absl::InvalidArgumentError(fmt::format("--depth-scale: {}", std::string(status.message())));
  }
  files.depth_scale = depth_scale_;
  absl::StatusOr<std::string> depth = read_input(depth_path_);
  if (!depth.ok()) return depth.status();
  files.depth = *std::move(depth);
  if (color_path_.empty()) return files;
  absl::StatusOr<std::string> color = read_input(color_path_);
  if (!color.ok()) return color.status();
  files.color = *std::move(color);
  return files;
}

}  // namespace segserve::segctl
