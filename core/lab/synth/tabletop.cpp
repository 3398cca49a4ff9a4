// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>
#include <iterator>
#include <limits>
#include <utility>

#include "core/base/status_macros.hpp"
#include "core/lab/synth/color_sensor.hpp"
#include "core/lab/synth/depth_sensor.hpp"
#include "core/lab/synth/scene.hpp"
#include "core/lab/synth/table_scene.hpp"
#include "core/lab/synth/visible_parts.hpp"

namespace segserve::synth {
namespace {

/// The scene as a perfect camera sees it.
struct Picture {
  DepthImage depth;
  std::vector<Vec3> color;
};

/// The table and the objects. Walls cast no shadows, because the lamp may be behind one.
World shadow_casters(const World& world) {
  World result;
  std::copy_if(world.begin(), world.end(), std::back_inserter(result),
               [](const Solid& solid) { return solid.label == kTable || solid.label >= 10; });
  return result;
}

Picture render(const TableScene& scene) {
  const Camera& camera = scene.camera;
  const RayCaster caster(scene.world, camera);
  const ShadowMap shadow(shadow_casters(scene.world), 2.5 * scene.lighting.lamp, {0, 0, 0}, 0.75);
  const std::size_t pixels = std::size_t{camera.width} * camera.height;
  Picture picture;
  picture.depth = {camera.width, camera.height, std::vector<double>(pixels), std::vector<float>(pixels),
                   std::vector<std::uint32_t>(pixels)};
  picture.color.resize(pixels);
  std::size_t i = 0;
  for (std::uint32_t v = 0; v < camera.height; ++v) {
    for (std::uint32_t u = 0; u < camera.width; ++u, ++i) {
      const Hit hit = caster.cast(u, v);
      if (!hit.exists()) continue;
      const Surface surface = caster.surface(u, v, hit);
      const Vec3 ray = unit(camera.pose.rotate_to_parent(camera.ray(u, v)));
      const double lit = shadow.lit_share(caster.world_point(u, v, hit.depth), surface.normal);
      picture.color[i] = scene.lighting.shade(color_at(scene.world[hit.solid].texture, surface), surface.normal, lit);
      picture.depth.depth[i] = hit.depth;
      picture.depth.incidence[i] = static_cast<float>(std::abs(dot(ray, surface.normal)));
      picture.depth.label[i] = scene.world[hit.solid].label;
    }
  }
  return picture;
}

/// Removes the depth of everything but the table and the objects, because OSD's scenes have ground truth only there.
void remove_room(DepthImage& image) {
  for (std::size_t i = 0; i < image.label.size(); ++i) {
    if (image.label[i] > kTable && image.label[i] < 10) image.depth[i] = 0;
  }
}

SyntheticScene to_cloud(const Camera& camera, const DepthImage& image, std::vector<std::uint32_t> rgb) {
  constexpr float kNaN = std::numeric_limits<float>::quiet_NaN();
  SyntheticScene scene;
  Cloud& cloud = scene.cloud;
  cloud.width = image.width;
  cloud.height = image.height;
  cloud.view = View::camera();
  cloud.x.assign(image.depth.size(), kNaN);
  cloud.y = cloud.z = cloud.x;
  cloud.rgb = std::move(rgb);
  scene.label = image.label;
  scene.camera = codec::Intrinsics{camera.focal, camera.focal, camera.center_u, camera.center_v};
  std::size_t i = 0;
  for (std::uint32_t v = 0; v < image.height; ++v) {
    for (std::uint32_t u = 0; u < image.width; ++u, ++i) {
      const double z = image.depth[i];
      if (z == 0) {
        scene.label[i] = 0;
        continue;
      }
      const Vec3 point = z * camera.ray(u, v);
      cloud.x[i] = static_cast<float>(point.x);
      cloud.y[i] = static_cast<float>(point.y);
      cloud.z[i] = static_cast<float>(point.z);
    }
  }
  return scene;
}

}  // namespace

absl::StatusOr<SyntheticScene> make_tabletop(const SceneOptions& options) {
  RETURN_IF_ERROR(check(options));
  const TableScene table = arrange_table(options);
  Picture picture = render(table);
  Random random(mix(options.seed) + 1);
  const ColorSensor color_sensor{options.noise};
  std::vector<std::uint32_t> rgb = color_sensor.record(options.width, options.height, picture.color, random);

  DepthImage& depth = picture.depth;
  if (!options.all_finite) remove_room(depth);
  const DepthSensor depth_sensor{
      .focal = table.camera.focal, .noise = options.noise, .holes = options.holes && !options.all_finite};
  depth_sensor.measure(depth, random);
  constexpr std::uint32_t kSpeckPixels = 16;
  label_visible_parts(options.width, options.height, kSpeckPixels, depth.label);
  return to_cloud(table.camera, depth, std::move(rgb));
}

}  // namespace segserve::synth
