// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>
#include <utility>

#include "core/base/status_macros.hpp"
#include "core/lab/synth/camera_frame.hpp"
#include "core/lab/synth/color_sensor.hpp"
#include "core/lab/synth/ray_caster.hpp"
#include "core/lab/synth/room_scene.hpp"
#include "core/lab/synth/scene.hpp"
#include "core/lab/synth/visible_parts.hpp"

namespace segserve::synth {
namespace {

/// A camera at this place that looks at the foot of the wall in the corner that is farthest away.
Camera look_across(const RoomScene& room, const Vec3& from, double aside, const RoomViewOptions& options) {
  const double far_x = from.x > 0 ? -room.half_x : room.half_x, far_y = from.y > 0 ? -room.half_y : room.half_y;
  const Vec3 to{far_x + aside * (from.x - far_x), far_y, 0.75};
  return look_at(from, to, 525.0 * options.width / 640, options.width, options.height);
}

/// The mean depth of what the camera sees.
double mean_depth(const World& world, const Camera& camera) {
  constexpr int kAcross = 16, kDown = 12;
  const RayCaster caster(world, camera);
  double sum = 0;
  for (int j = 0; j < kDown; ++j) {
    for (int i = 0; i < kAcross; ++i) {
      sum += caster.cast((i + 0.5) / kAcross * (camera.width - 1), (j + 0.5) / kDown * (camera.height - 1)).depth;
    }
  }
  return sum / (kAcross * kDown);
}

/// The camera with the longest view, of some that look across the room from places where nothing stands.
Camera choose_camera(const RoomScene& room, const RoomViewOptions& options, Random& random) {
  constexpr std::size_t kCandidates = 12;
  Camera best;
  double longest = 0;
  for (std::size_t i = 0; i < std::min(kCandidates, room.views.size()); ++i) {
    const Camera camera = look_across(room, room.views[i].pose.origin, random.uniform(0, 0.5), options);
    const double depth = mean_depth(room.world, camera);
    if (depth <= longest) continue;
    longest = depth;
    best = camera;
  }
  return best;
}

}  // namespace

absl::StatusOr<SyntheticScene> make_room_view(const RoomViewOptions& options) {
  RETURN_IF_ERROR(check(options));
  RoomScene room = arrange_room(
      {.seed = options.seed, .size = options.size, .objects = options.objects, .furnished = options.furnished});
  Lighting lighting;
  lighting.lamp = unit(room.lamp);
  lighting.window = unit({1, 0.4, 0.5});
  const ShadowMap shadow(room.world, room.lamp, {0, 0, 0}, 1.3 * std::max(room.half_x, room.half_y));
  add_ceiling(room);
  Random random(mix(options.seed) + 3);
  const Camera camera = choose_camera(room, options, random);
  Picture picture = render(room.world, camera, lighting, shadow);
  std::vector<std::uint32_t> rgb =
      ColorSensor{options.noise}.record(options.width, options.height, picture.color, random);
  measure_depth(options.sensor, camera.focal, options.noise, options.holes, picture, random);
  label_visible_parts(options.width, options.height, kSpeckPixels, picture.depth.label);
  return to_cloud(camera, picture.depth, std::move(rgb));
}

}  // namespace segserve::synth
