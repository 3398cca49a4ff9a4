// SPDX-License-Identifier: Apache-2.0
#include "core/region_graph/borders.hpp"

#include <algorithm>

#include "core/base/stop_check.hpp"
#include "core/math/elementary.hpp"

namespace segserve {
namespace {

/// The angle by which a contact is concave.
class Concavity {
 public:
  /// `dead_zone` is in degrees.
  explicit Concavity(double dead_zone) : dead_zone_(dead_zone) {
    if (dead_zone > 0 && dead_zone < 180) flat_cosine_ = math::cos(dead_zone * math::kDegree) + kMargin;
  }

  /// Whether the angle between two unit normals is surely within the dead zone. That of most contacts is, which saves
  /// their arctangents.
  bool is_flat(const Vec3& na, const Vec3& nb) const { return dot(na, nb) > flat_cosine_; }

  /// The angle between the unit normals beyond the dead zone, in degrees, if the contact is concave, else 0.
  double angle(const Vec3& xa, const Vec3& na, const Vec3& xb, const Vec3& nb) const {
    if (dot(na - nb, xa - xb) >= 0 || na == Vec3{} || nb == Vec3{}) return 0;
    return std::max(0.0, math::atan2(norm(cross(na, nb)), dot(na, nb)) / math::kDegree - dead_zone_);
  }

 private:
  static constexpr double kMargin = 1e-9;  // far larger than rounding errors

  double dead_zone_;
  double flat_cosine_ = 2;  // normals with a larger cosine are surely within the dead zone
};

}  // namespace

absl::Status measure_borders(const FrameContext& frame, const RegionGraph& graph, const VoxelGrid& grid,
                             const std::vector<Vec3>& normals, const DeadZone& zone, std::vector<Border>& borders) {
  StopCheck check(frame.stop);
  borders.assign(graph.edges.size(), Border{});
  const Concavity concavity(zone.angle);
  check.for_each(0, graph.contacts.size(), [&](std::size_t c) {
    const auto [v, u] = graph.contacts[c];
    Border& border = borders[graph.edge_of_contact[c]];
    border.contacts += 1;
    if (concavity.is_flat(normals[v], normals[u])) return;
    const double angle = concavity.angle(grid.centroid[v], normals[v], grid.centroid[u], normals[u]);
    border.concavity +=
        std::max(0.0, angle - zone.noise * frame.scale.excess_noise(depth_of(frame.scale, grid.centroid[v])));
  });
  check.for_each(0, borders.size(), [&](std::size_t e) { borders[e].concavity /= borders[e].contacts; });
  return check.status();
}

}  // namespace segserve
