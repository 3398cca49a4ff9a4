#include "segserve/supervoxel/seeds.hpp"

#include <algorithm>
#include <array>
#include <span>

#include "segserve/math/elementary.hpp"
#include "segserve/math/radix_sort.hpp"

namespace segserve {
namespace {

constexpr std::int64_t kRowStep = std::int64_t{1} << kCellBits;
constexpr std::int64_t kLayerStep = std::int64_t{1} << (2 * kCellBits);

/// The voxels sorted by the seed cell that holds their centroid.
class SeedCells {
 public:
  SeedCells(const VoxelGrid& grid, double resolution, StopCheck& check)
      : grid_(grid), resolution_(resolution), check_(check) {
    std::vector<VoxelKey> cell_of_voxel(grid.size());
    check.for_each(0, grid.size(), [&](std::size_t v) { cell_of_voxel[v] = cell(grid.centroid[v]); });
    math::sort_order(cell_of_voxel, voxels_, check);
    check.for_each(0, voxels_.size(), [&](std::size_t i) {
      const VoxelKey key = cell_of_voxel[voxels_[i]];
      if (!keys_.empty() && keys_.back() == key) return;
      keys_.push_back(key);
      begin_.push_back(static_cast<std::uint32_t>(i));
    });
    begin_.push_back(static_cast<std::uint32_t>(voxels_.size()));
  }

  std::size_t size() const { return keys_.size(); }
  std::span<const std::uint32_t> voxels(std::size_t c) const {
    return std::span(voxels_).subspan(begin_[c], begin_[c + 1] - begin_[c]);
  }

  std::uint32_t nearest_to_centre(std::size_t c) const {
    const auto coordinate = [&](int shift) {
      const auto index = static_cast<std::int64_t>(keys_[c] >> shift & (kRowStep - 1)) - kCellBias;
      return (static_cast<double>(index) + 0.5) * resolution_;
    };
    const Vec3 centre{coordinate(0), coordinate(kCellBits), coordinate(2 * kCellBits)};
    const auto distance = [&](std::uint32_t v) {
      const Vec3 d = grid_.centroid[v] - centre;
      return dot(d, d);
    };
    std::uint32_t nearest = voxels(c)[0];
    double smallest = distance(nearest);
    check_.for_each(1, voxels(c).size(), [&](std::size_t i) {
      const double d = distance(voxels(c)[i]);
      if (d < smallest) smallest = d, nearest = voxels(c)[i];
    });
    return nearest;
  }

  /// Voxels whose centroid is within `radius` (at most the resolution) of that of `v`, itself included.
  std::size_t count_within(std::uint32_t v, double radius) const {
    const Vec3& middle = grid_.centroid[v];
    std::size_t count = 0;
    for (double dz : {-radius, radius}) {
      for (double dy : {-radius, radius}) {
        const VoxelKey first = cell(middle + Vec3{-radius, dy, dz});
        const VoxelKey last = cell(middle + Vec3{radius, dy, dz});
        if (skip_repeated(middle, radius, dy, dz)) continue;
        for (auto c = static_cast<std::size_t>(std::ranges::lower_bound(keys_, first) - keys_.begin());
             c < keys_.size() && keys_[c] <= last; ++c) {
          check_.for_each(0, voxels(c).size(), [&, of_cell = voxels(c)](std::size_t i) {
            const Vec3 d = grid_.centroid[of_cell[i]] - middle;
            if (dot(d, d) <= radius * radius) ++count;
          });
        }
      }
    }
    return count;
  }

 private:
  VoxelKey cell(const Vec3& p) const {
    return static_cast<VoxelKey>(axis(p.z) * kLayerStep + axis(p.y) * kRowStep + axis(p.x));
  }
  std::int64_t axis(double metres) const { return std::int64_t{math::floor_to_int(metres / resolution_)} + kCellBias; }
  /// The ball reaches into at most two rows a direction; if both ends lie in the same one, visit it once.
  bool skip_repeated(const Vec3& middle, double radius, double dy, double dz) const {
    return (dy > 0 && axis(middle.y - radius) == axis(middle.y + radius)) ||
           (dz > 0 && axis(middle.z - radius) == axis(middle.z + radius));
  }

  const VoxelGrid& grid_;
  double resolution_;
  StopCheck& check_;
  std::vector<std::uint32_t> voxels_;
  std::vector<VoxelKey> keys_;
  std::vector<std::uint32_t> begin_;
};

}  // namespace

void select_seeds(const VoxelGrid& grid, const View& view, double voxel_resolution, double seed_resolution,
                  Seeds& seeds, const StopToken& stop) {
  seeds.chosen.clear();
  seeds.sparse.clear();
  StopCheck check(stop);
  const SeedCells cells(grid, seed_resolution, check);
  const double radius = 0.5 * seed_resolution;
  for (std::size_t c = 0; c < cells.size() && !check.after(1); ++c) {
    const std::uint32_t seed = cells.nearest_to_centre(c);
    const double voxel = voxel_edge(voxel_resolution, view, grid.centroid[seed]);
    const double disc = math::kPi * radius * radius / (voxel * voxel);
    const bool enough = static_cast<double>(cells.count_within(seed, radius)) > 0.05 * disc;
    (enough ? seeds.chosen : seeds.sparse).push_back(seed);
  }
}

}  // namespace segserve
