// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <iterator>
#include <utility>

#include "core/base/status_macros.hpp"
#include "core/lab/synth/camera_frame.hpp"
#include "core/lab/synth/color_sensor.hpp"
#include "core/lab/synth/scene.hpp"
#include "core/lab/synth/table_scene.hpp"
#include "core/lab/synth/visible_parts.hpp"

namespace segserve::synth {
namespace {

/// The table and the objects. Walls cast no shadows, because the lamp may be behind one.
World shadow_casters(const World& world) {
  World result;
  std::copy_if(world.begin(), world.end(), std::back_inserter(result),
               [](const Solid& solid) { return solid.label == kTable || solid.label >= 10; });
  return result;
}

/// Removes the depth of everything but the table and the objects, because OSD's scenes have ground truth only there.
void remove_room(DepthImage& image) {
  for (std::size_t i = 0; i < image.label.size(); ++i) {
    if (image.label[i] > kTable && image.label[i] < 10) image.depth[i] = 0;
  }
}

}  // namespace

absl::StatusOr<SyntheticScene> make_tabletop(const SceneOptions& options) {
  RETURN_IF_ERROR(check(options));
  const TableScene table = arrange_table(options);
  const ShadowMap shadow(shadow_casters(table.world), 2.5 * table.lighting.lamp, {0, 0, 0}, 0.75);
  Picture picture = render(table.world, table.camera, table.lighting, shadow);
  Random random(mix(options.seed) + 1);
  const ColorSensor color_sensor{options.noise};
  std::vector<std::uint32_t> rgb = color_sensor.record(options.width, options.height, picture.color, random);

  if (!options.all_finite) remove_room(picture.depth);
  measure_depth(options.sensor, table.camera.focal, options.noise, options.holes && !options.all_finite, picture,
                random);
  label_visible_parts(options.width, options.height, kSpeckPixels, picture.depth.label);
  return to_cloud(table.camera, picture.depth, std::move(rgb));
}

}  // namespace segserve::synth
