// SPDX-License-Identifier: Apache-2.0
#include "client/segctl/rgbd_output.hpp"

#include <memory>
#include <utility>

#include "core/base/status_macros.hpp"
#include "core/base/status_text.hpp"
#include "core/lab/picture/picture.hpp"
#include "fmt/format.h"
#include "segserve/codec/rgbd_encode.hpp"

namespace segserve::segctl {
namespace {

/// The colors of every pixel, those without depth included.
picture::Image color_image(const CloudView& cloud) {
  picture::Image image{cloud.width, cloud.height, {}};
  image.rgb.reserve(3 * cloud.size());
  for (const std::uint32_t rgb : cloud.rgb) image.rgb.insert(image.rgb.end(), {red(rgb), green(rgb), blue(rgb)});
  return image;
}

}  // namespace

void RgbdOutput::add_to(CLI::App& app, const std::string& group) {
  depth_scale_ = codec::RgbdOptions{}.depth_scale;
  CLI::Option* depth = app.add_option("--depth", depth_path_, "write the depth image, a 16-bit gray PNG")
                           ->type_name("PNG")
                           ->group(group);
  app.add_option("--rgb", color_path_, "write the color image: .jpg, or .png without loss")
      ->type_name("IMAGE")
      ->needs(depth)
      ->group(group);
  app.add_option("--depth-scale", depth_scale_, "meters a unit of depth in that image")
      ->type_name("METERS")
      ->capture_default_str()
      ->needs(depth)
      ->group(group);
}

absl::Status RgbdOutput::announce(StagedOutput& output) const {
  if (!wanted()) return absl::OkStatus();
  if (!depth_path_.ends_with(".png")) {
    return absl::InvalidArgumentError(fmt::format("--depth {}: the name must end in .png", depth_path_));
  }
  if (const absl::Status status = codec::check_depth_scale(depth_scale_); !status.ok()) {
    return absl::InvalidArgumentError(fmt::format("--depth-scale: {}", message_of(status)));
  }
  RETURN_IF_ERROR(output.announce(depth_path_));
  if (color_path_.empty()) return absl::OkStatus();
  if (!color_path_.ends_with(".jpg") && !color_path_.ends_with(".jpeg") && !color_path_.ends_with(".png")) {
    return absl::InvalidArgumentError(fmt::format("--rgb {}: the name must end in .jpg, .jpeg or .png", color_path_));
  }
  return output.announce(color_path_);
}

absl::Status RgbdOutput::add(StagedOutput& output, const CloudView& cloud, const codec::Intrinsics& camera) const {
  ASSIGN_OR_RETURN(auto files, codec::encode_rgbd(cloud, {.depth_scale = depth_scale_, .intrinsics = camera}));
  output.add(depth_path_, std::move(files.depth));
  if (color_path_.empty()) return absl::OkStatus();
  if (color_path_.ends_with(".png")) {
    auto image = std::make_shared<const picture::Image>(color_image(cloud));
    output.add(color_path_, [image](const std::string& path) { return picture::write_png(path, *image); });
  } else {
    output.add(color_path_, std::move(files.color));
  }
  return absl::OkStatus();
}

std::string RgbdOutput::as_input_flags(const codec::Intrinsics& camera) const {
  std::string flags = fmt::format("--depth {}", depth_path_);
  if (!color_path_.empty()) flags += fmt::format(" --rgb {}", color_path_);
  flags += fmt::format(" --intrinsics {},{},{},{}", camera.fx, camera.fy, camera.cx, camera.cy);
  if (depth_scale_ != codec::RgbdOptions{}.depth_scale) flags += fmt::format(" --depth-scale {}", depth_scale_);
  return flags;
}

}  // namespace segserve::segctl
