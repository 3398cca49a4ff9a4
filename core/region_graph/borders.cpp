#include "core/region_graph/borders.hpp"

#include <algorithm>
#include <array>
#include <span>

#include "core/base/stop_check.hpp"
#include "core/math/elementary.hpp"

namespace segserve {
namespace {

/// The angle by which a pair of voxels is concave.
class Concavity {
 public:
  explicit Concavity(double dead_zone) : dead_zone_(dead_zone) {
    if (dead_zone > 0 && dead_zone < 180) flat_ = math::cos(dead_zone * math::kDegree) + kClear;
  }

  /// Whether unit normals are surely within the dead zone: nine of ten pairs, without looking at anything else.
  bool flat(const Vec3& na, const Vec3& nb) const { return dot(na, nb) > flat_; }

  /// Angle of the unit normals beyond the dead zone in degrees where the pair is concave, else 0.
  double operator()(const Vec3& xa, const Vec3& na, const Vec3& xb, const Vec3& nb) const {
    if (dot(na - nb, xa - xb) >= 0 || na == Vec3{} || nb == Vec3{}) return 0;
    return std::max(0.0, math::atan2(norm(cross(na, nb)), dot(na, nb)) / math::kDegree - dead_zone_);
  }

 private:
  static constexpr double kClear = 1e-9;  // far beyond rounding errors

  double dead_zone_;
  double flat_ = 2;  // a larger cosine of the normals: surely within the dead zone
};

constexpr std::size_t kTogether = 512;  // contacts

/// The contacts that are not surely flat, without a branch for each. Returns their number; `bent` has room for all and
/// one more.
std::size_t find_bent(const Concavity& concavity, const std::vector<Vec3>& normals, std::span<const Contact> contacts,
                      Contact* bent) {
  std::size_t found = 0;
  for (const Contact& contact : contacts) {
    bent[found] = contact;
    found += static_cast<std::size_t>(!concavity.flat(normals[contact.v], normals[contact.u]));
  }
  return found;
}

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
  const auto edge_of = [&](const Contact& contact) {
    const std::uint32_t s = supervoxels.of_voxel[contact.v], t = supervoxels.of_voxel[contact.u];
    return edges.find(std::min(s, t), std::max(s, t));
  };
  std::vector<std::uint32_t> pairs(borders.size());
  std::array<Contact, kTogether + 1> bent;
  check.for_each_block(0, graph.contacts.size(), [&](std::size_t begin, std::size_t end) {
    for (std::size_t first = begin; first < end; first += kTogether) {
      const auto some = graph.contacts.subspan(first, std::min(kTogether, end - first));
      for (const Contact& contact : some) ++pairs[edge_of(contact)];
      const std::size_t count = find_bent(concavity, normals, some, bent.data());
      for (const Contact& contact : std::span(bent).first(count)) {
        const auto [v, u] = contact;
        borders[edge_of(contact)].concavity += concavity(grid.centroid[v], normals[v], grid.centroid[u], normals[u]);
      }
    }
  });
  check.for_each(0, borders.size(), [&](std::size_t e) {
    borders[e].voxel_pairs = pairs[e];
    borders[e].concavity /= borders[e].voxel_pairs;
  });
}

}  // namespace segserve
