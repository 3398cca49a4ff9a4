// SPDX-License-Identifier: Apache-2.0
#include "core/lab/synth/spinning_lidar.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include "core/lab/synth/ray_caster.hpp"

namespace segserve::synth {
namespace {

constexpr double kRangeNoise = 0.015;  // meters, at any range
constexpr double kLongest = 100;       // meters
constexpr double kShortest = 0.4;      // meters
constexpr double kLost = 0.01;         // share of the rays that get no echo
constexpr double kLeastIncidence = 0.03;

/// The rays of a turn, cast by pinhole cameras that stand in a circle.
class Panorama {
 public:
  Panorama(const World& world, const Vec3& position) {
    constexpr double kFocal = 256;
    constexpr std::uint32_t kWidth = 224, kHeight = 352;  // 47 degrees across, and elevations up to 32 degrees
    casters_.reserve(kSectors);
    for (int sector = 0; sector < kSectors; ++sector) {
      const double azimuth = 2 * math::kPi * (sector + 0.5) / kSectors;
      const Vec3 ahead{math::cos(azimuth), math::sin(azimuth), 0};
      casters_.emplace_back(world, look_at(position, position + ahead, kFocal, kWidth, kHeight), kLongest);
    }
  }

  struct Ray {
    const RayCaster* caster;
    double u, v;
  };
  /// `turns` from +x, counterclockwise, [0, 1).
  Ray ray(double turns, double elevation) const {
    const auto sector = std::min(static_cast<int>(turns * kSectors), kSectors - 1);
    const RayCaster& caster = casters_[static_cast<std::size_t>(sector)];
    const Camera& camera = caster.camera();
    const double left = 2 * math::kPi * (turns - (sector + 0.5) / kSectors);
    const double x = -math::sin(left) / math::cos(left);
    const double y = -math::sin(elevation) / (math::cos(elevation) * math::cos(left));
    return {&caster, camera.center_u + camera.focal * x, camera.center_v + camera.focal * y};
  }

 private:
  static constexpr int kSectors = 8;
  std::vector<RayCaster> casters_;
};

}  // namespace

double SpinningLidar::elevation(std::uint32_t ring) const {
  struct Range {
    double low, high;  // degrees
  };
  const Range range = rings == 16   ? Range{-15, 15}
                      : rings == 32 ? Range{-30.67, 10.67}
                      : rings == 64 ? Range{-24.8, 2}
                                    : Range{-22.5, 22.5};
  return math::kDegree * (range.high - (range.high - range.low) * ring / (rings - 1));
}

SyntheticScene SpinningLidar::sweep(const World& world, const Vec3& position, const Relief& relief,
                                    Random& random) const {
  const Panorama panorama(world, position);
  SyntheticScene scene;
  Cloud& cloud = scene.cloud;
  const std::size_t points = std::size_t{rings} * columns;
  cloud.width = columns;
  cloud.height = rings;
  cloud.view = View::world(0, 0, 0);
  cloud.x.assign(points, std::numeric_limits<float>::quiet_NaN());
  cloud.y = cloud.z = cloud.x;
  scene.label.assign(points, 0);
  for (std::uint32_t column = 0; column < columns; ++column) {
    const double turned = (column + 0.5) / columns;
    const double turns = turned < 0.5 ? 0.5 - turned : 1.5 - turned;
    for (std::uint32_t ring = 0; ring < rings; ++ring) {
      const double error = noise * kRangeNoise * random.gaussian();
      const double luck = noise > 0 ? random.uniform() : 1;
      const Panorama::Ray ray = panorama.ray(turns, elevation(ring));
      const Hit hit = ray.caster->cast(ray.u, ray.v);
      if (!hit.exists() || luck < kLost) continue;
      const Vec3 away = ray.caster->world_point(ray.u, ray.v, hit.depth) - position;
      const double range = norm(away);
      const double incidence = std::abs(dot(ray.caster->surface(ray.u, ray.v, hit).normal, away)) / range;
      if (range < kShortest || range > kLongest || incidence < kLeastIncidence * (1 - luck)) continue;
      const double measured = range + error + (relief ? relief(hit.solid, position + away, range) : 0);
      const Vec3 point = (measured / range) * away;
      const std::size_t i = std::size_t{ring} * columns + column;
      cloud.x[i] = static_cast<float>(point.x);
      cloud.y[i] = static_cast<float>(point.y);
      cloud.z[i] = static_cast<float>(point.z);
      scene.label[i] = world[hit.solid].label;
    }
  }
  return scene;
}

}  // namespace segserve::synth
