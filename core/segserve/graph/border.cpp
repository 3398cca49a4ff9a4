#include "segserve/graph/border.hpp"

#include <algorithm>
#include <array>

#include "segserve/math/elementary.hpp"

namespace segserve {
namespace {

/// The angle by which a pair of voxels is concave.
class Concavity {
 public:
  explicit Concavity(double dead_zone) : dead_zone_(dead_zone) {
    if (dead_zone > 0 && dead_zone < 180) flat_ = math::cos(dead_zone * math::kDegree) + kClear;
  }

  /// Angle of the unit normals beyond the dead zone in degrees where the pair is concave, else 0.
  double operator()(const Vec3& xa, const Vec3& na, const Vec3& xb, const Vec3& nb) const {
    const double cosine = dot(na, nb);
    if (cosine > flat_) return 0;  // within the dead zone: nine of ten pairs, without looking at anything else
    if (dot(na - nb, xa - xb) >= 0 || na == Vec3{} || nb == Vec3{}) return 0;
    return std::max(0.0, math::atan2(norm(cross(na, nb)), cosine) / math::kDegree - dead_zone_);
  }

 private:
  static constexpr double kClear = 1e-9;  // far beyond rounding errors

  double dead_zone_;
  double flat_ = 2;  // a larger cosine of the normals: surely within the dead zone
};

/// Finds the edges of a graph by their regions.
class EdgeIndex {
 public:
  EdgeIndex(const RegionGraph& graph, StopCheck& check)
      : edges_(graph.edges), first_(graph.regions.size() + 1, graph.edges.size()) {
    // Edges with the same smaller region stand together: (a, b) is found by a search among those of a.
    for (std::size_t e = edges_.size(); e-- > 0 && !check.after(1);) first_[edges_[e].a] = e;
    for (std::size_t r = graph.regions.size(); r-- > 0 && !check.after(1);) {
      first_[r] = std::min(first_[r], first_[r + 1]);
    }
  }

  /// The edge between a and b, a < b, which must exist. Neighbouring voxels ask for the same few edges again and again:
  /// nineteen of twenty searches are spared.
  std::size_t find(std::uint32_t a, std::uint32_t b) {
    Answer& last = last_[(31 * a + b) % last_.size()];
    if (last.edge != RegionEdge{a, b}) last = {{a, b}, search(a, b)};
    return last.index;
  }

 private:
  struct Answer {
    RegionEdge edge;  // none has a == b
    std::size_t index = 0;
  };

  std::size_t search(std::uint32_t a, std::uint32_t b) const {
    const auto begin = edges_.begin() + static_cast<std::ptrdiff_t>(first_[a]);
    const auto end = edges_.begin() + static_cast<std::ptrdiff_t>(first_[a + 1]);
    const auto edge = std::lower_bound(begin, end, b, [](const RegionEdge& e, std::uint32_t id) { return e.b < id; });
    return static_cast<std::size_t>(edge - edges_.begin());
  }

  const std::vector<RegionEdge>& edges_;
  std::vector<std::size_t> first_;
  std::array<Answer, 1024> last_{};
};

}  // namespace

void measure_borders(const RegionGraph& graph, const VoxelGrid& grid, const std::vector<Vec3>& normals,
                     const Supervoxels& supervoxels, double dead_zone, const StopToken& stop,
                     std::vector<Border>& borders) {
  StopCheck check(stop);
  EdgeIndex edges(graph, check);
  borders.assign(graph.edges.size(), Border{});
  const Concavity concavity(dead_zone);
  check.for_each(0, graph.contacts.size(), [&](std::size_t c) {
    const auto [v, u] = graph.contacts[c];
    const std::uint32_t s = supervoxels.of_voxel[v], t = supervoxels.of_voxel[u];
    Border& border = borders[edges.find(std::min(s, t), std::max(s, t))];
    border.voxel_pairs += 1;
    const double angle = concavity(grid.centroid[v], normals[v], grid.centroid[u], normals[u]);
    if (angle > 0) border.concavity += angle;
  });
  check.for_each(0, borders.size(), [&](std::size_t e) { borders[e].concavity /= borders[e].voxel_pairs; });
}

}  // namespace segserve
