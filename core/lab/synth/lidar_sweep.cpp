// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cstddef>
#include <map>

#include "core/base/status_macros.hpp"
#include "core/lab/synth/room_scene.hpp"
#include "core/lab/synth/scene.hpp"
#include "core/lab/synth/spinning_lidar.hpp"
#include "core/lab/synth/street_scene.hpp"

namespace segserve::synth {
namespace {

SyntheticScene sweep_street(const SpinningLidar& lidar, std::uint64_t seed) {
  constexpr double kHeight = 1.7;  // meters above the ground
  const StreetScene street = arrange_street(seed);
  Random random(mix(seed) + 4);
  Random leaves(mix(seed) + 5);
  const auto relief = [&](std::uint32_t solid, const Vec3& point, double range) {
    // The ray meets higher ground that much earlier.
    if (street.world[solid].label == kGround) return -range * ground_height(seed, point.x, point.y) / kHeight;
    const double depth = street.depth_of_leaves[solid];
    return depth > 0 ? depth * leaves.uniform() : 0;
  };
  return lidar.sweep(street.world, {0, 0, kHeight}, relief, random);
}

/// The place nearest to the middle of the room, of some where nothing stands.
Vec3 choose_place(const RoomScene& room) {
  constexpr std::size_t kCandidates = 8;
  const auto eccentricity = [&](const Camera& camera) {
    const double x = camera.pose.origin.x / room.half_x, y = camera.pose.origin.y / room.half_y;
    return x * x + y * y;
  };
  const auto end = room.views.begin() + static_cast<std::ptrdiff_t>(std::min(kCandidates, room.views.size()));
  return std::ranges::min_element(room.views.begin(), end, {}, eccentricity)->pose.origin;
}

SyntheticScene sweep_room(const SpinningLidar& lidar, const LidarOptions& options) {
  RoomScene room = arrange_room(
      {.seed = options.seed, .size = options.size, .objects = options.objects, .furnished = options.furnished});
  add_ceiling(room);
  Random random(mix(options.seed) + 6);
  return lidar.sweep(room.world, choose_place(room), nullptr, random);
}

/// Takes the label from objects of which too few points are seen to tell what they are.
void ignore_crumbs(std::vector<std::uint32_t>& label) {
  constexpr std::size_t kFewest = 10;
  std::map<std::uint32_t, std::size_t> points;
  for (const std::uint32_t l : label) ++points[l];
  for (std::uint32_t& l : label) {
    if (l >= 10 && points[l] < kFewest) l = 0;
  }
}

/// Leaves out the rays without an echo. Points are in the order in which they were measured, column by column.
SyntheticScene unorganized(const SyntheticScene& sweep) {
  SyntheticScene scene;
  Cloud& cloud = scene.cloud;
  cloud.view = sweep.cloud.view;
  for (std::uint32_t column = 0; column < sweep.cloud.width; ++column) {
    for (std::uint32_t ring = 0; ring < sweep.cloud.height; ++ring) {
      const std::size_t i = std::size_t{ring} * sweep.cloud.width + column;
      if (!is_finite(sweep.cloud.x[i], sweep.cloud.y[i], sweep.cloud.z[i])) continue;
      cloud.x.push_back(sweep.cloud.x[i]);
      cloud.y.push_back(sweep.cloud.y[i]);
      cloud.z.push_back(sweep.cloud.z[i]);
      scene.label.push_back(sweep.label[i]);
    }
  }
  cloud.width = static_cast<std::uint32_t>(cloud.size());
  cloud.height = 1;
  return scene;
}

}  // namespace

absl::StatusOr<SyntheticScene> make_lidar_sweep(const LidarOptions& options) {
  RETURN_IF_ERROR(check(options));
  const SpinningLidar lidar{.rings = options.rings, .columns = options.columns, .noise = options.noise};
  SyntheticScene sweep = options.street ? sweep_street(lidar, options.seed) : sweep_room(lidar, options);
  ignore_crumbs(sweep.label);
  return options.organized ? sweep : unorganized(sweep);
}

}  // namespace segserve::synth
