// SPDX-License-Identifier: Apache-2.0
#include "core/lab/synth/moving_tabletop.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "core/base/status_macros.hpp"
#include "core/lab/synth/camera_frame.hpp"
#include "core/lab/synth/color_sensor.hpp"
#include "core/math/eigen_conversion.hpp"
#include "core/math/random.hpp"

namespace segserve::synth {
namespace {

using Footprint = Arrangement::Footprint;

constexpr double kWayGap = 0.01;                          // meters that a moving object keeps from others
constexpr int kStopsPerWay = 12;                          // places on a way that are tried
constexpr int kTriesPerWay = 60;                          // ways of an object that are tried
constexpr double kShortestWay = 0.06, kLongestWay = 0.3;  // of a way, meters

/// 0 at whole periods, 1 between them, with rests at both ends.
double to_and_fro(double seconds, double period, double delay) {
  const double turns = seconds / period + delay;
  return 0.5 - 0.5 * math::cos(2 * kPi * (turns - math::floor_to_int(turns)));
}

double swing(double seconds, double period, double phase) {
  const double turns = seconds / period + phase;
  return math::sin(2 * kPi * (turns - math::floor_to_int(turns)));
}

Footprint moved(Footprint f, const Vec3& by, double turns) {
  f.x += by.x, f.y += by.y, f.turns += turns;
  return f;
}

bool stands_on_table(const Footprint& f) { return std::fabs(f.bottom) < 1e-6; }

/// Whether another object stands on this one.
bool carries(const Footprint& f, const std::vector<Footprint>& all) {
  const auto reach = [](const Footprint& g) { return std::sqrt(g.half_x * g.half_x + g.half_y * g.half_y); };
  return std::ranges::any_of(all, [&](const Footprint& g) {
    const double x = g.x - f.x, y = g.y - f.y;
    return g.bottom > 1e-6 && std::sqrt(x * x + y * y) < reach(f) + reach(g);
  });
}

bool is_over_table(const Footprint& f) {
  constexpr double kHalfX = 0.46, kNear = -0.42, kFar = 0.46;
  return std::fabs(f.x) <= kHalfX && f.y >= kNear && f.y <= kFar;
}

}  // namespace

absl::StatusOr<MovingTabletop> MovingTabletop::make(const MovingOptions& options) {
  RETURN_IF_ERROR(check(options));
  MovingTabletop scene(options);
  scene.plan_ways();
  return scene;
}

void MovingTabletop::plan_ways() {
  Random random(mix(options_.scene.seed) + 2);
  const std::vector<Footprint>& all = table_.footprints;
  std::vector<std::vector<Footprint>> places(all.size());  // that each object takes in the course of time
  for (std::size_t i = 0; i < all.size(); ++i) places[i] = {all[i]};
  const auto is_free = [&](std::size_t own, const Footprint& f) {
    Arrangement others;
    for (std::size_t i = 0; i < places.size(); ++i) {
      for (const Footprint& g : places[i]) {
        if (i != own) others.occupy(g);
      }
    }
    return others.is_free(f, kWayGap);
  };
  for (std::size_t i = 0; i < all.size() && ways_.size() < options_.moving && options_.speed > 0; ++i) {
    if (!stands_on_table(all[i]) || carries(all[i], all)) continue;
    for (int attempt = 0; attempt < kTriesPerWay; ++attempt) {
      const double direction = 2 * kPi * random.uniform(), length = random.uniform(kShortestWay, kLongestWay);
      Way way;
      way.label = kFirstObject + kObjectStep * static_cast<std::uint32_t>(i);
      way.center = {all[i].x, all[i].y, 0};
      way.along = {length * math::cos(direction), length * math::sin(direction), 0};
      way.turns = random.uniform(-0.15, 0.15);
      way.period = kPi * length / options_.speed;  // the highest speed is pi length / period
      way.delay = random.uniform();
      std::vector<Footprint> stops;
      for (int stop = 0; stop <= kStopsPerWay; ++stop) {
        const double share = stop / static_cast<double>(kStopsPerWay);
        stops.push_back(moved(all[i], share * way.along, share * way.turns));
      }
      const bool fits =
          std::ranges::all_of(stops, [&](const Footprint& f) { return is_over_table(f) && is_free(i, f); });
      if (!fits) continue;
      places[i] = std::move(stops);
      ways_.push_back(way);
      break;
    }
  }
}

Camera MovingTabletop::camera_at(double seconds) const {
  Random random(mix(options_.scene.seed) + 3);
  const Camera& start = table_.camera;
  const Vec3 target{0, 0.02, 0.03};
  const Vec3 from = start.pose.origin - target;
  const auto swings = [&](double amplitude, double shortest, double longest) {
    const double period = random.uniform(shortest, longest), phase = random.uniform();
    return options_.camera_motion * amplitude * (swing(seconds, period, phase) - swing(0, period, phase));
  };
  // Around the table by 17 degrees to each side, up and down, closer and away; and the target wanders.
  const Pose turn = rotated(swings(0.047, 7, 10), {});
  const double lift = swings(0.08, 5, 8), nearer = swings(0.08, 6, 9);
  const double across = swings(0.04, 4, 7), along = swings(0.04, 4, 7);
  const Vec3 place = (1 + nearer) * turn.rotate_to_parent(from) + Vec3{0, 0, lift};
  return look_at(target + place, target + Vec3{across, along, 0}, start.focal, start.width, start.height);
}

World MovingTabletop::world_at(double seconds) const {
  World world = table_.world;
  for (const Way& way : ways_) {
    const double share = to_and_fro(seconds, way.period, way.delay);
    const Pose motion =
        translated(way.center + share * way.along) * rotated(share * way.turns, {}) * translated(-way.center);
    for (Solid& solid : world) {
      if (solid.label == way.label) solid.pose = motion * solid.pose;
    }
  }
  return world;
}

MovingFrame MovingTabletop::frame(std::uint32_t index) const {
  const SceneOptions& options = options_.scene;
  MovingFrame result;
  result.time = index / options_.rate;
  const World world = world_at(result.time);
  const Camera camera = camera_at(result.time);
  const ShadowMap shadow(shadow_casters(world), 2.5 * table_.lighting.lamp, {0, 0, 0}, 0.75);
  Picture picture = render(world, camera, table_.lighting, shadow);
  Random random(mix(mix(options.seed) + index) + 1);
  std::vector<std::uint32_t> rgb =
      ColorSensor{options.noise}.record(options.width, options.height, picture.color, random);
  if (!options.all_finite) remove_room(picture.depth);
  measure_depth(options.sensor, camera.focal, options.noise, options.holes && !options.all_finite, picture, random);
  result.scene = to_cloud(camera, picture.depth, std::move(rgb));
  result.pose.rotation << to_eigen(camera.pose.x), to_eigen(camera.pose.y), to_eigen(camera.pose.z);
  result.pose.translation = to_eigen(camera.pose.origin);
  return result;
}

}  // namespace segserve::synth
