// SPDX-License-Identifier: Apache-2.0
#include <utility>

#include "core/base/status_macros.hpp"
#include "core/lab/synth/camera_frame.hpp"
#include "core/lab/synth/color_sensor.hpp"
#include "core/lab/synth/scene.hpp"
#include "core/lab/synth/table_scene.hpp"
#include "core/lab/synth/visible_parts.hpp"

namespace segserve::synth {

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
