// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>
#include <vector>

#include "core/base/status_macros.hpp"
#include "core/lab/synth/depth_sensor.hpp"
#include "core/lab/synth/packed_color.hpp"
#include "core/lab/synth/ray_caster.hpp"
#include "core/lab/synth/room_scene.hpp"
#include "core/lab/synth/scene.hpp"
#include "core/lab/synth/surface_grid.hpp"

namespace segserve::synth {
namespace {

constexpr double kNear = 0.4, kRange = 4.0;  // range of a Kinect: depth in meters
constexpr double kRaysPerPoint = 6;
constexpr double kFramesPerView = 16;  // A view stands for so many frames; averaging divides noise by the root.
constexpr double kGrazing = 0.15;      // least cosine of incidence that is measured
constexpr double kSurplus = 1.1;       // cells per wanted point; surplus cells are dropped

/// Scans the room. The rays depend only on the room and the number of points, not on the grid.
class Scanner {
 public:
  Scanner(const RoomScene& room, double noise, std::uint64_t seed)
      : room_(room),
        noise_(noise),
        seed_(seed),
        shadow_(room.world, room.lamp, {0, 0, 0}, 1.3 * std::max(room.half_x, room.half_y)) {
    lighting_.lamp = unit(room.lamp);
    lighting_.window = unit({1, 0.4, 0.5});
  }

  SurfaceGrid scan(double points, double spacing) const {
    SurfaceGrid grid(spacing, {0, 0, 0}, static_cast<std::size_t>(1.05 * kSurplus * points));
    const double pixels = kRaysPerPoint * points / static_cast<double>(room_.views.size());
    const double height = std::floor(std::sqrt(0.75 * pixels)) + 1;
    Random random(seed_);
    for (Camera view : room_.views) {
      view.height = static_cast<std::uint32_t>(height);
      view.width = static_cast<std::uint32_t>(std::floor(pixels / height)) + 1;
      view.focal *= view.height / 480.0;
      view.center_u = (view.width - 1) / 2.0;
      view.center_v = (view.height - 1) / 2.0;
      scan_view(view, random, grid);
    }
    return grid;
  }

 private:
  // Rays are spread at random within their pixels, so that the cloud shows no pattern of pixels.
  void scan_view(const Camera& view, Random& random, SurfaceGrid& grid) const {
    const RayCaster caster(room_.world, view, kRange);
    for (std::uint32_t row = 0; row < view.height; ++row) {
      for (std::uint32_t column = 0; column < view.width; ++column) {
        const double u = column + random.uniform(-0.5, 0.5);
        const double v = row + random.uniform(-0.5, 0.5);
        const double error = random.gaussian();
        const Hit hit = caster.cast(u, v);
        if (hit.exists() && hit.depth > kNear) fuse(caster, u, v, hit, error, grid);
      }
    }
  }

  void fuse(const RayCaster& caster, double u, double v, const Hit& hit, double error, SurfaceGrid& grid) const {
    const Pose& pose = caster.camera().pose;
    const Vec3 ray = pose.rotate_to_parent(caster.camera().ray(u, v));
    const Vec3 point = pose.origin + hit.depth * ray;
    const Surface surface = caster.surface(u, v, hit);
    const double facing = dot(ray, surface.normal);
    if (facing * facing < kGrazing * kGrazing * dot(ray, ray)) return;
    const Solid& solid = room_.world[hit.solid];
    SurfaceGrid::Cell& cell = grid.find_or_add(point);
    if (cell.weight == 0) {
      cell.label = solid.label;
      cell.rgb = packed_color(
          lighting_.shade(color_at(solid.texture, surface), surface.normal, shadow_.lit_share(point, surface.normal)));
    }
    if (cell.label != solid.label) return;  // A cell keeps the label of the surface that was seen in it first.
    constexpr double kDamping = 0.25;       // 1 / sqrt(kFramesPerView)
    static_assert(kDamping * kDamping * kFramesPerView == 1);
    const double depth = hit.depth + noise_ * kDamping * axial_noise(hit.depth) * error;
    grid.add(cell, pose.origin + depth * ray, 1 / (hit.depth * hit.depth));
  }

  const RoomScene& room_;
  double noise_;
  std::uint64_t seed_;
  ShadowMap shadow_;
  Lighting lighting_;
};

/// The spacing at which a scan for so many points fills `kSurplus` cells per point, found with a scan for few points:
/// as rays are proportional to points, the number of cells is proportional to the inverse square of the spacing.
double find_spacing(const Scanner& scanner, double points) {
  const double few = std::clamp(points / 64, 1000.0, 20000.0);
  double low = 1e-3, high = 1;
  for (int i = 0; i < 9; ++i) {
    const double middle = std::sqrt(low * high);
    const bool enough = static_cast<double>(scanner.scan(few, middle).cells().size()) > kSurplus * few;
    (enough ? low : high) = middle;
  }
  return low * std::sqrt(few / points);
}

/// The points of exactly `points` cells, chosen by the hash of their position, in the order in which they were found.
SyntheticScene to_cloud(const SurfaceGrid& grid, std::uint32_t points, const View& view) {
  const auto& cells = grid.cells();
  std::vector<std::uint64_t> rank(cells.size());
  std::transform(cells.begin(), cells.end(), rank.begin(), [](const auto& cell) { return mix(cell.key); });
  std::nth_element(rank.begin(), rank.begin() + (points - 1), rank.end());
  const std::uint64_t last = rank[points - 1];
  SyntheticScene scene;
  scene.cloud.resize(points, true);
  scene.cloud.width = points;
  scene.cloud.height = 1;
  scene.cloud.view = view;
  scene.label.reserve(points);
  for (const SurfaceGrid::Cell& cell : cells) {
    if (mix(cell.key) > last) continue;
    const std::size_t i = scene.label.size();
    const Vec3 p = grid.position(cell);
    scene.cloud.x[i] = static_cast<float>(p.x);
    scene.cloud.y[i] = static_cast<float>(p.y);
    scene.cloud.z[i] = static_cast<float>(p.z);
    scene.cloud.rgb[i] = cell.rgb;
    scene.label.push_back(cell.label);
  }
  return scene;
}

View mean_view(const RoomScene& room) {
  Vec3 sum;
  for (const Camera& view : room.views) sum += view.pose.origin;
  const Vec3 mean = (1.0 / static_cast<double>(room.views.size())) * sum;
  return View::world(static_cast<float>(mean.x), static_cast<float>(mean.y), static_cast<float>(mean.z));
}

}  // namespace

absl::StatusOr<SyntheticScene> make_fused_room(const RoomOptions& options) {
  RETURN_IF_ERROR(check(options));
  const RoomScene room = arrange_room(options);
  const Scanner scanner(room, options.noise, mix(options.seed) + 2);
  double spacing = find_spacing(scanner, options.points);
  SurfaceGrid grid = scanner.scan(options.points, spacing);
  while (grid.cells().size() < options.points) {  // The estimate was too coarse; finer cells are more cells.
    spacing *= 0.95;
    grid = scanner.scan(options.points, spacing);
  }
  return to_cloud(grid, options.points, mean_view(room));
}

}  // namespace segserve::synth
