// SPDX-License-Identifier: Apache-2.0
#include "core/lab/synth/table_scene.hpp"

#include <algorithm>
#include <cmath>
#include <iterator>

#include "core/lab/synth/arrangement.hpp"

namespace segserve::synth {
namespace {

constexpr double kTableHeight = 0.74;  // meters above the floor

Texture surface(TextureKind kind, const Vec3& base, const Vec3& second, double scale, bool across, Random& random) {
  return {kind, base, second, second, scale, across, random.bits()};
}

Texture table_top(Random& random) {
  static constexpr Vec3 kWoods[] = {{0.78, 0.65, 0.56}, {0.70, 0.54, 0.38}, {0.55, 0.40, 0.28}, {0.83, 0.76, 0.64}};
  if (random.chance(0.25)) {
    const double gray = random.uniform(0.62, 0.88);
    return surface(TextureKind::kPlain, {gray, gray, 0.98 * gray}, {}, 0.02, false, random);
  }
  const Vec3 wood = kWoods[random.below(4)];
  return surface(TextureKind::kWood, 1.06 * wood, 0.86 * wood, random.uniform(0.01, 0.025), true, random);
}

void add_table(double half_x, double near, double far, Random& random, World& world) {
  const Texture top = table_top(random);
  world.push_back(box_between({-half_x, near, -0.028}, {half_x, far, 0}, top, kTable));
  const Texture legs = surface(TextureKind::kPlain, {0.3, 0.3, 0.32}, {}, 0.02, false, random);
  for (const double x : {-half_x + 0.05, half_x - 0.1}) {
    for (const double y : {near + 0.05, far - 0.1}) {
      world.push_back(box_between({x, y, -kTableHeight}, {x + 0.05, y + 0.05, -0.028}, legs, kTable));
    }
  }
}

/// Adds a closed room around the table and the camera, so that every ray of the camera hits something. Its slabs
/// overlap at the edges.
void add_shell(const Vec3& low, const Vec3& high, Random& random, World& world) {
  const Vec3 parquet{0.42, 0.29, 0.19};
  const double tint = random.uniform(0.72, 0.9);
  const Vec3 paint{tint, tint, tint * random.uniform(0.9, 1.02)};
  const Texture walls = surface(TextureKind::kPlain, paint, {}, 0.02, false, random);
  const Texture boards = surface(TextureKind::kWood, 1.2 * parquet, 0.8 * parquet, 0.05, true, random);
  const double t = 0.1;
  const Vec3 outer_low = low - Vec3{t, t, t}, outer_high = high + Vec3{t, t, t};
  world.push_back(box_between(outer_low, {outer_high.x, outer_high.y, low.z}, boards, kFloor));
  world.push_back(box_between({outer_low.x, high.y, outer_low.z}, outer_high, walls, kBackWall));
  world.push_back(box_between({high.x, outer_low.y, outer_low.z}, outer_high, walls, kSideWall));
  world.push_back(box_between(outer_low, {low.x, outer_high.y, outer_high.z}, walls, kOtherWall));
  world.push_back(box_between(outer_low, {outer_high.x, low.y, outer_high.z}, walls, kOtherWall));
  world.push_back(box_between({outer_low.x, outer_low.y, high.z}, outer_high, walls, kOtherWall));
}

void add_room(double half_x, double far, const Vec3& camera, Random& random, World& world) {
  const double left = -2.2 - random.uniform(0, 0.5), right = std::max(half_x, camera.x) + random.uniform(0.1, 0.45);
  const double back = far + random.uniform(0.7, 1.2), front = std::min(-2.5, camera.y - 0.8);
  const double floor = -kTableHeight, ceiling = std::max(2.0, camera.z + 0.5);
  add_shell({left, front, floor}, {right, back, ceiling}, random, world);
  const double width = random.uniform(0.5, 0.9), cabinet = random.uniform(-half_x - 0.3, half_x - 0.9);
  const double height = random.uniform(-0.1, 0.5);
  const Texture drawers =
      surface(TextureKind::kStripes, {0.62, 0.62, 0.64}, {0.5, 0.5, 0.53}, random.uniform(0.15, 0.3), false, random);
  world.push_back(
      box_between({cabinet, back - 0.5, floor}, {cabinet + width, back - 0.001, height}, drawers, kCabinet));
}

Camera place_camera(const SceneOptions& options, Random& random) {
  const double distance = options.distance * random.uniform(0.8, 1.3);
  const double pitch = random.uniform(30.0, 50.0) / 360;
  const double yaw = random.uniform(-0.06, 0.06);
  const double across = random.uniform(-0.05, 0.05);
  const Vec3 target{across, 0.02, 0.03};
  const double ground = distance * math::cos(2 * kPi * pitch);
  const double height = distance * math::sin(2 * kPi * pitch);
  const Vec3 from = target + Vec3{ground * math::sin(2 * kPi * yaw), -ground * math::cos(2 * kPi * yaw), height};
  return look_at(from, target, 525.0 * options.width / 640, options.width, options.height);
}

}  // namespace

TableScene arrange_table(const SceneOptions& options) {
  Random random(options.seed);
  TableScene scene;
  scene.camera = place_camera(options, random);
  const double half_x = random.uniform(0.5, 0.62), near = -random.uniform(0.62, 0.75) * std::max(1.0, options.distance),
               far = random.uniform(0.6, 1.0);
  add_table(half_x, near, far, random, scene.world);
  add_room(half_x, far, scene.camera.pose.origin, random, scene.world);

  // More objects take more of the table. Clutter moves them closer together.
  const double crowd = std::sqrt(std::max(1U, options.objects) / 8.0);
  const double spread = std::min(1.0, crowd * (1 - 0.45 * options.clutter));
  const Shelf shelf{translated({0, 0, 0}), 0.42 * spread + 0.03, 0.34 * spread + 0.03};
  const PlacementOptions placement{0.004 + 0.05 * (1 - options.clutter), options.stacked,
                                   options.hollow    ? random_hollow_object
                                   : options.compact ? random_compact_object
                                                     : random_household_object};
  Arrangement arrangement;
  place_objects(options.objects, shelf, placement, kFirstObject, random, arrangement, scene.world);
  scene.footprints = arrangement.occupied();

  const double side = random.uniform(-0.5, 0.5);
  scene.lighting.lamp = unit({side, random.uniform(-0.5, 0.2), 1});
  scene.lighting.window = unit({random.chance(0.5) ? 1.0 : -1.0, random.uniform(-0.6, 0.3), 0.5});
  return scene;
}

World shadow_casters(const World& world) {
  World result;
  std::copy_if(world.begin(), world.end(), std::back_inserter(result),
               [](const Solid& solid) { return solid.label == kTable || solid.label >= 10; });
  return result;
}

void remove_room(DepthImage& image) {
  for (std::size_t i = 0; i < image.label.size(); ++i) {
    if (image.label[i] > kTable && image.label[i] < 10) image.depth[i] = 0;
  }
}

}  // namespace segserve::synth
