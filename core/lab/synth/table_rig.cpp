// SPDX-License-Identifier: Apache-2.0
#include "core/lab/synth/table_rig.hpp"

#include <utility>

#include "core/base/status_macros.hpp"
#include "core/lab/synth/camera_frame.hpp"
#include "core/lab/synth/color_sensor.hpp"
#include "core/lab/synth/table_scene.hpp"
#include "core/math/eigen_conversion.hpp"
#include "core/math/random.hpp"
#include "fmt/format.h"

namespace segserve::synth {

absl::StatusOr<std::vector<RigView>> make_tabletop_rig(const SceneOptions& options, std::uint32_t cameras) {
  constexpr std::uint32_t kMost = 16;
  RETURN_IF_ERROR(check(options));
  if (cameras < 1 || cameras > kMost) {
    return absl::InvalidArgumentError(fmt::format("cameras: {} is not from 1 to {}", cameras, kMost));
  }
  if (options.all_finite) return absl::InvalidArgumentError("all_finite: there is no room around several cameras");
  const TableScene table = arrange_table(options);
  const World world = shadow_casters(table.world);  // a wall would stand between a camera and the table
  const ShadowMap shadow(world, 2.5 * table.lighting.lamp, {0, 0, 0}, 0.75);
  std::vector<RigView> views(cameras);
  for (std::uint32_t c = 0; c < cameras; ++c) {
    Camera camera = table.camera;
    camera.pose = rotated(c / static_cast<double>(cameras), {}) * camera.pose;
    Picture picture = render(world, camera, table.lighting, shadow);
    Random random(mix(mix(options.seed) + c) + 4);
    std::vector<std::uint32_t> rgb =
        ColorSensor{options.noise}.record(options.width, options.height, picture.color, random);
    measure_depth(options.sensor, camera.focal, options.noise, options.holes, picture, random);
    views[c].scene = to_cloud(camera, picture.depth, std::move(rgb));
    views[c].pose.rotation << to_eigen(camera.pose.x), to_eigen(camera.pose.y), to_eigen(camera.pose.z);
    views[c].pose.translation = to_eigen(camera.pose.origin);
  }
  return views;
}

}  // namespace segserve::synth
