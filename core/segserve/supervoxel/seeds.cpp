#include "segserve/supervoxel/seeds.hpp"

#include <algorithm>
#include <bit>
#include <limits>
#include <span>

#include "segserve/math/elementary.hpp"
#include "segserve/math/radix_sort.hpp"

namespace segserve {
namespace {

struct CellIndex {
  std::int32_t x, y, z;
};

/// The cells of a cubic grid between two corners as keys that sort by z, then y, then x, with as few bits as these
/// take: a third of the passes of sorting 21 bits a coordinate.
class CellKeys {
 public:
  CellKeys() = default;
  CellKeys(const CellIndex& low, const CellIndex& high) : low_(low), high_(high) {
    x_bits_ = width(low.x, high.x);
    y_bits_ = width(low.y, high.y);
  }

  std::uint64_t key(const CellIndex& c) const {
    return offset(low_.z, c.z) << (x_bits_ + y_bits_) | offset(low_.y, c.y) << x_bits_ | offset(low_.x, c.x);
  }
  CellIndex cell(std::uint64_t key) const {
    const auto part = [&](int shift, int bits) {
      return static_cast<std::int32_t>(key >> shift & ((std::uint64_t{1} << bits) - 1));
    };
    return {low_.x + part(0, x_bits_), low_.y + part(x_bits_, y_bits_), low_.z + part(x_bits_ + y_bits_, 31)};
  }
  bool has_row(const CellIndex& c) const { return c.y >= low_.y && c.y <= high_.y && c.z >= low_.z && c.z <= high_.z; }
  std::int32_t clamp_x(std::int32_t x) const { return std::clamp(x, low_.x, high_.x); }

 private:
  static std::uint64_t offset(std::int32_t low, std::int32_t c) {
    return static_cast<std::uint64_t>(std::int64_t{c} - std::int64_t{low});
  }
  static int width(std::int32_t low, std::int32_t high) { return static_cast<int>(std::bit_width(offset(low, high))); }

  CellIndex low_{}, high_{};
  int x_bits_ = 0, y_bits_ = 0;
};

/// The voxels sorted by the seed cell that holds their centroid.
class SeedCells {
 public:
  SeedCells(const VoxelGrid& grid, double resolution, SeedScratch& scratch, StopCheck& check)
      : grid_(grid),
        resolution_(resolution),
        check_(check),
        voxels_(scratch.voxels),
        cells_(scratch.cells),
        begin_(scratch.begin) {
    find_keys();
    scratch.cell_of_voxel.resize(grid.size());
    check.for_each(0, grid.size(),
                   [&](std::size_t v) { scratch.cell_of_voxel[v] = keys_.key(cell(grid.centroid[v])); });
    math::sort_order(scratch.cell_of_voxel, voxels_, scratch.previous, check);
    cells_.clear();
    begin_.clear();
    check.for_each(0, voxels_.size(), [&](std::size_t i) {
      const std::uint64_t key = scratch.cell_of_voxel[voxels_[i]];
      if (!cells_.empty() && cells_.back() == key) return;
      cells_.push_back(key);
      begin_.push_back(static_cast<std::uint32_t>(i));
    });
    begin_.push_back(static_cast<std::uint32_t>(voxels_.size()));
  }

  std::size_t size() const { return cells_.size(); }
  std::span<const std::uint32_t> voxels(std::size_t c) const {
    return std::span(voxels_).subspan(begin_[c], begin_[c + 1] - begin_[c]);
  }

  std::uint32_t nearest_to_centre(std::size_t c) const {
    const auto middle = [&](std::int32_t index) { return (static_cast<double>(index) + 0.5) * resolution_; };
    const CellIndex index = keys_.cell(cells_[c]);
    const Vec3 centre{middle(index.x), middle(index.y), middle(index.z)};
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

  /// Whether more than `limit` voxels have their centroids within `radius` (at most the resolution) of that of `v`,
  /// which is one of cell c, itself included. Mostly the cell alone has enough, which spares the search for others.
  bool more_within(std::size_t c, std::uint32_t v, double radius, double limit) const {
    double count = 0;
    if (exceeds(c, v, radius, limit, count)) return true;
    count = 0;
    const Vec3& middle = grid_.centroid[v];
    for (double dz : {-radius, radius}) {
      for (double dy : {-radius, radius}) {
        if (skip_repeated(middle, radius, dy, dz)) continue;
        const CellIndex row = cell(middle + Vec3{-radius, dy, dz});
        if (!keys_.has_row(row)) continue;
        const std::uint64_t first = keys_.key({keys_.clamp_x(row.x), row.y, row.z});
        const std::uint64_t last = keys_.key({keys_.clamp_x(axis(middle.x + radius)), row.y, row.z});
        for (auto o = static_cast<std::size_t>(std::ranges::lower_bound(cells_, first) - cells_.begin());
             o < cells_.size() && cells_[o] <= last; ++o) {
          if (exceeds(o, v, radius, limit, count)) return true;
        }
      }
    }
    return false;
  }

 private:
  /// Adds the voxels of cell c that are within the radius of v to the count, until it exceeds the limit.
  bool exceeds(std::size_t c, std::uint32_t v, double radius, double limit, double& count) const {
    for (const std::uint32_t u : voxels(c)) {
      const Vec3 d = grid_.centroid[u] - grid_.centroid[v];
      if (check_.after(1)) return false;
      if (dot(d, d) <= radius * radius && ++count > limit) return true;
    }
    return false;
  }
  void find_keys() {
    constexpr std::int32_t kLargest = std::numeric_limits<std::int32_t>::max();
    CellIndex low{kLargest, kLargest, kLargest}, high{-kLargest, -kLargest, -kLargest};
    check_.for_each(0, grid_.size(), [&](std::size_t v) {
      const CellIndex c = cell(grid_.centroid[v]);
      low = {std::min(low.x, c.x), std::min(low.y, c.y), std::min(low.z, c.z)};
      high = {std::max(high.x, c.x), std::max(high.y, c.y), std::max(high.z, c.z)};
    });
    if (low.x <= high.x) keys_ = CellKeys(low, high);
  }

  CellIndex cell(const Vec3& p) const { return {axis(p.x), axis(p.y), axis(p.z)}; }
  std::int32_t axis(double metres) const { return math::floor_to_int(metres / resolution_); }
  /// The ball reaches into at most two rows a direction; if both ends lie in the same one, visit it once.
  bool skip_repeated(const Vec3& middle, double radius, double dy, double dz) const {
    return (dy > 0 && axis(middle.y - radius) == axis(middle.y + radius)) ||
           (dz > 0 && axis(middle.z - radius) == axis(middle.z + radius));
  }

  const VoxelGrid& grid_;
  double resolution_;
  StopCheck& check_;
  CellKeys keys_;
  std::vector<std::uint32_t>& voxels_;
  std::vector<std::uint64_t>& cells_;
  std::vector<std::uint32_t>& begin_;
};

}  // namespace

void select_seeds(const VoxelGrid& grid, const View& view, double voxel_resolution, double seed_resolution,
                  SeedScratch& scratch, Seeds& seeds, const StopToken& stop) {
  seeds.chosen.clear();
  seeds.sparse.clear();
  StopCheck check(stop);
  const SeedCells cells(grid, seed_resolution, scratch, check);
  const double radius = 0.5 * seed_resolution;
  for (std::size_t c = 0; c < cells.size() && !check.after(1); ++c) {
    const std::uint32_t seed = cells.nearest_to_centre(c);
    const double voxel = voxel_edge(voxel_resolution, view, grid.centroid[seed]);
    const double disc = math::kPi * radius * radius / (voxel * voxel);
    (cells.more_within(c, seed, radius, 0.05 * disc) ? seeds.chosen : seeds.sparse).push_back(seed);
  }
}

}  // namespace segserve
