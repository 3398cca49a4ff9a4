// SPDX-License-Identifier: Apache-2.0
#include "core/tracking/support_frame.hpp"

#include <cmath>
#include <cstdint>

#include "core/math/eigen_conversion.hpp"
#include "core/math/symmetric_matrix3.hpp"

namespace segserve::tracking {
namespace {

constexpr double kLarge = 0.1;      // of the area of the scene that the plane must have
constexpr double kFlat = 0.03;      // deviation from the plane, relative to the square root of the area
constexpr double kSameTilt = 0.9;   // cosine of the angle to the plane before
constexpr double kSamePlace = 0.2;  // of the distance from the sensor

/// The sensor, or the middle of the cameras.
Vec3 viewpoint(const View& view) {
  if (view.sensor) return to_vec3(view.sensor->cast<double>());
  if (view.cameras.empty()) return Vec3{};
  Vec3 sum;
  for (const CameraPoints& camera : view.cameras) sum += to_vec3(camera.sensor.cast<double>());
  return (1.0 / static_cast<double>(view.cameras.size())) * sum;
}

Vec3 towards_sensor(const Vec3& normal, const Vec3& point, const View& view) {
  if (!view.has_sensor()) return normal.z < 0 ? -normal : normal;
  const Vec3 sensor = viewpoint(view);
  return dot(normal, sensor - point) < 0 ? -normal : normal;
}

std::optional<Plane> plane_of(const SceneTree& scene, std::uint32_t node, const View& view) {
  const Vec3 center = scene.node(node).center();
  const double area = scene.area(node);
  Symmetric3 scatter;
  for (std::size_t i = scene.begin(node); i < scene.end(node); ++i) {
    const std::uint32_t leaf = scene.leaf_order()[i];
    scatter += scene.leaf_area(leaf) * outer(scene.leaf_center(leaf) - center);
  }
  const Vec3 normal = smallest_eigenvector(scatter);
  if (normal == Vec3{}) return std::nullopt;
  const Vec3 product{dot({scatter.xx, scatter.xy, scatter.xz}, normal),
                     dot({scatter.xy, scatter.yy, scatter.yz}, normal),
                     dot({scatter.xz, scatter.yz, scatter.zz}, normal)};
  if (dot(normal, product) > kFlat * kFlat * area * area) return std::nullopt;
  const Vec3 up = towards_sensor(normal, center, view);
  return Plane{up, dot(up, center)};
}

bool is_same(const Plane& a, const Plane& b) {
  return dot(a.normal, b.normal) >= kSameTilt &&
         std::fabs(a.offset - b.offset) <= kSamePlace * (1 + std::fabs(a.offset));
}

}  // namespace

std::optional<Plane> find_plane(const SceneTree& scene, const Segmentation& segmentation, const View& view,
                                const std::optional<Plane>& before) {
  if (segmentation.support_plane && segmentation.support_plane->points > 0) {
    return Plane{to_vec3(segmentation.support_plane->normal), segmentation.support_plane->offset};
  }
  if (scene.node_count() == 0) return std::nullopt;
  const double least = kLarge * scene.node(scene.node_count() - 1).area;
  std::optional<Plane> best;
  double best_rank = 0;
  for (const std::uint32_t node : scene.segments()) {
    if (scene.area(node) < least) continue;
    const std::optional<Plane> plane = plane_of(scene, node, view);
    if (!plane) continue;
    // Any plane that may be the one before ranks above all others.
    constexpr double kAbove = 1e30;
    const double rank = scene.area(node) + (before && is_same(*before, *plane) ? kAbove : 0);
    if (rank > best_rank) best_rank = rank, best = plane;
  }
  return best;
}

RigidMotion support_frame(const std::optional<Plane>& plane, const View& view) {
  const Vec3 up = plane ? plane->normal : view.kind == ViewKind::kCamera ? Vec3{0, -1, 0} : Vec3{0, 0, 1};
  const Vec3 axis = up.x * up.x < 0.5 ? Vec3{1, 0, 0} : Vec3{0, 1, 0};
  const Vec3 x = unit(axis - dot(axis, up) * up);
  return {x, cross(up, x), up, (plane ? plane->offset : 0) * up};
}

}  // namespace segserve::tracking
