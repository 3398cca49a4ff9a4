#include "segserve/voxel/normals.hpp"

#include "segserve/math/symmetric3.hpp"
#include "segserve/pipeline/parallel.hpp"
#include "segserve/voxel/orientation.hpp"

namespace segserve {
namespace {

/// Number, sum and second moments of points.
struct Moments {
  double count = 0;
  Vec3 sum;
  Symmetric3 square;

  Moments& operator+=(const Moments& o) {
    count += o.count, sum += o.sum, square += o.square;
    return *this;
  }
};

/// The normal of the plane through points with these moments.
Vec3 plane_normal(const Moments& m) {
  Symmetric3 scatter = m.square;
  scatter += (-1 / m.count) * outer(m.sum);
  return smallest_eigenvector(scatter);
}

/// With the adjacency A that includes the voxel itself, and M the moments of single centroids, the two
/// rings have the moments M + A M + A (A M): two sparse passes instead of a visit to 81 voxels.
class TwoRingMoments {
 public:
  TwoRingMoments(const VoxelGrid& grid, const VoxelAdjacency& adjacency, unsigned threads, const StopToken& stop)
      : grid_(grid), adjacency_(adjacency), ring_(grid.size()) {
    parallel_ranges(grid.size(), threads, [&](std::size_t begin, std::size_t end) {
      StopCheck(stop, threads).for_each(begin, end, [this](std::size_t i) {
        const auto v = static_cast<std::uint32_t>(i);
        ring_[v] = one_ring(v);
        return 1 + adjacency_.of(v).size();
      });
    });
  }

  /// Moments about the voxel's own centroid, which keeps them exact far from the origin.
  Moments about(std::uint32_t v) const {
    const Vec3& origin = grid_.centroid[v];
    Moments total = ring_[v];
    total += ring_[v];
    total.count += 1;  // the voxel itself, at the origin
    for (const std::uint32_t u : adjacency_.of(v)) total += moved(ring_[u], u, origin);
    return total;
  }

 private:
  /// Of the voxel and its neighbours, about the voxel's centroid.
  Moments one_ring(std::uint32_t v) const {
    Moments m;
    m.count = 1;
    for (const std::uint32_t u : adjacency_.of(v)) {
      const Vec3 d = grid_.centroid[u] - grid_.centroid[v];
      m.count += 1;
      m.sum += d;
      m.square += outer(d);
    }
    return m;
  }

  /// Moments about the centroid of u, taken about `origin` instead.
  Moments moved(const Moments& m, std::uint32_t u, const Vec3& origin) const {
    const Vec3 t = grid_.centroid[u] - origin;
    Moments r = m;
    r.sum += m.count * t;
    r.square += m.count * outer(t);
    r.square += {2 * t.x * m.sum.x, t.x * m.sum.y + t.y * m.sum.x, t.x * m.sum.z + t.z * m.sum.x,
                 2 * t.y * m.sum.y, t.y * m.sum.z + t.z * m.sum.y, 2 * t.z * m.sum.z};
    return r;
  }

  const VoxelGrid& grid_;
  const VoxelAdjacency& adjacency_;
  std::vector<Moments> ring_;
};

}  // namespace

Vec3 turn_to_sensor(const Vec3& normal, const Vec3& position, const View& view) {
  Vec3 sensor;
  if (view.sensor) sensor = {(*view.sensor)[0], (*view.sensor)[1], (*view.sensor)[2]};
  return dot(normal, sensor - position) < 0 ? -normal : normal;
}

absl::Status compute_normals(const VoxelGrid& grid, const VoxelAdjacency& adjacency, const View& view, unsigned threads,
                             const StopToken& stop, std::vector<Vec3>& normals) {
  normals.resize(grid.size());
  const TwoRingMoments moments(grid, adjacency, threads, stop);
  if (absl::Status status = stop.check(); !status.ok()) return status;
  parallel_ranges(grid.size(), threads, [&](std::size_t begin, std::size_t end) {
    StopCheck(stop, threads).for_each(begin, end, [&](std::size_t i) {
      const auto v = static_cast<std::uint32_t>(i);
      const Vec3 normal = plane_normal(moments.about(v));
      normals[v] = view.has_sensor() ? turn_to_sensor(normal, grid.centroid[v], view) : normal;
      return 1 + adjacency.of(v).size();
    });
  });
  if (absl::Status status = stop.check(); !status.ok()) return status;
  return view.has_sensor() ? absl::OkStatus() : orient_consistently(adjacency, stop, normals);
}

}  // namespace segserve
