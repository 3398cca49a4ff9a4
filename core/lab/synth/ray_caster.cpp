// SPDX-License-Identifier: Apache-2.0
#include "core/lab/synth/ray_caster.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>

namespace segserve::synth {
namespace {

constexpr std::uint32_t kTile = 16;  // pixels
constexpr double kNearest = 1e-3;    // meters; closer surfaces are not seen

struct Interval {
  double low, high;
};

/// The range of x / z over a sphere in front of the camera, from its two tangents through the origin.
Interval slopes(double x, double z, double radius) {
  const double square = z * z - radius * radius;
  const double root = radius * std::sqrt(std::max(0.0, x * x + square));
  return {(x * z - root) / square, (x * z + root) / square};
}

std::uint32_t tile_of(double pixel, std::uint32_t tiles) {
  return static_cast<std::uint32_t>(std::clamp(std::floor(pixel / kTile), 0.0, tiles - 1.0));
}

}  // namespace

RayCaster::RayCaster(const World& world, const Camera& camera, double range)
    : world_(world), camera_(camera), range_(range), tiles_across_((camera.width + kTile - 1) / kTile) {
  candidates_.reserve(world.size());
  for (const Solid& solid : world) {
    const Sphere sphere = bounding_sphere(solid.shape);
    Candidate c;
    c.origin = solid.pose.to_local(camera.pose.origin);
    c.right = solid.pose.rotate_to_local(camera.pose.x);
    c.down = solid.pose.rotate_to_local(camera.pose.y);
    c.ahead = solid.pose.rotate_to_local(camera.pose.z);
    c.center = camera.pose.to_local(solid.pose.to_parent(sphere.center));
    c.squared_tangent = dot(c.center, c.center) - sphere.radius * sphere.radius;
    c.nearest = c.center.z - sphere.radius;
    candidates_.push_back(c);
  }
  tiles_.resize(std::size_t{tiles_across_} * ((camera.height + kTile - 1) / kTile));
  std::vector<std::uint32_t> order(world.size());
  std::iota(order.begin(), order.end(), 0U);
  std::stable_sort(order.begin(), order.end(), [this](std::uint32_t a, std::uint32_t b) {
    return candidates_[a].nearest < candidates_[b].nearest;
  });
  for (const std::uint32_t solid : order) add_to_tiles(solid);
}

void RayCaster::add_to_tiles(std::uint32_t solid) {
  const Candidate& c = candidates_[solid];
  const double radius = c.center.z - c.nearest;
  if (c.center.z + radius < kNearest || c.nearest > range_) return;
  const auto tiles_down = static_cast<std::uint32_t>(tiles_.size() / tiles_across_);
  std::uint32_t left = 0, top = 0, right = tiles_across_ - 1, bottom = tiles_down - 1;
  if (c.nearest > kNearest) {
    const Interval x = slopes(c.center.x, c.center.z, radius);
    const Interval y = slopes(c.center.y, c.center.z, radius);
    const double u0 = camera_.center_u + camera_.focal * x.low, u1 = camera_.center_u + camera_.focal * x.high;
    const double v0 = camera_.center_v + camera_.focal * y.low, v1 = camera_.center_v + camera_.focal * y.high;
    if (u1 < -1 || v1 < -1 || u0 > camera_.width || v0 > camera_.height) return;
    left = tile_of(u0 - 1, tiles_across_), right = tile_of(u1 + 1, tiles_across_);
    top = tile_of(v0 - 1, tiles_down), bottom = tile_of(v1 + 1, tiles_down);
  }
  for (std::uint32_t j = top; j <= bottom; ++j) {
    for (std::uint32_t i = left; i <= right; ++i) tiles_[std::size_t{j} * tiles_across_ + i].push_back(solid);
  }
}

Hit RayCaster::cast(double u, double v) const {
  const Vec3 ray = camera_.ray(u, v);
  const double square = dot(ray, ray);
  const auto tile_u = static_cast<std::size_t>(std::max(0.0, u)) / kTile;
  const auto tile_v = static_cast<std::size_t>(std::max(0.0, v)) / kTile;
  Hit hit;
  Crossing best{range_, 0};
  for (const std::uint32_t index : tiles_[tile_v * tiles_across_ + tile_u]) {
    const Candidate& c = candidates_[index];
    if (c.nearest > best.t) break;
    const double middle = dot(c.center, ray);
    if (c.squared_tangent > 0 && (middle < 0 || middle * middle < square * c.squared_tangent)) continue;
    const Vec3 direction = ray.x * c.right + ray.y * c.down + c.ahead;
    if (intersect(world_[index].shape, c.origin, direction, kNearest, best)) hit.solid = index;
  }
  hit.depth = best.t;
  hit.face = best.face;
  return hit;
}

Vec3 RayCaster::world_point(double u, double v, double depth) const {
  return camera_.pose.to_parent(depth * camera_.ray(u, v));
}

Surface RayCaster::surface(double u, double v, const Hit& hit) const {
  const Candidate& c = candidates_[hit.solid];
  const Vec3 ray = camera_.ray(u, v);
  const Vec3 point = c.origin + hit.depth * (ray.x * c.right + ray.y * c.down + c.ahead);
  Surface surface = surface_at(world_[hit.solid].shape, point, hit.face);
  surface.normal = world_[hit.solid].pose.rotate_to_parent(surface.normal);
  return surface;
}

}  // namespace segserve::synth
