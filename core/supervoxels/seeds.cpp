#include "core/supervoxels/seeds.hpp"

#include <algorithm>
#include <bit>
#include <limits>

#include "core/base/radix_sort.hpp"
#include "core/base/stop_check.hpp"
#include "core/math/elementary.hpp"

namespace segserve {
namespace {

using CellIndex = SeedScratch::Cell;

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

/// The voxels by the seed cell that holds their centroid. What is sorted are runs of consecutive voxels in one cell, of
/// which there are a fraction of the voxels.
class SeedCells {
 public:
  SeedCells(const VoxelGrid& grid, double resolution, SeedScratch& scratch, StopCheck& check)
      : grid_(grid),
        resolution_(resolution),
        check_(check),
        run_(scratch.run),
        order_(scratch.order),
        cells_(scratch.cells),
        begin_(scratch.begin) {
    find_runs(scratch.cell_of_run);
    scratch.keys.resize(run_.size() - 1);
    check.for_each(0, scratch.keys.size(), [&](std::size_t r) { scratch.keys[r] = keys_.key(scratch.cell_of_run[r]); });
    math::sort_order(scratch.keys, order_, scratch.sort, check);
    cells_.clear();
    begin_.clear();
    check.for_each(0, order_.size(), [&](std::size_t i) {
      const std::uint64_t key = scratch.keys[order_[i]];
      if (!cells_.empty() && cells_.back() == key) return;
      cells_.push_back(key);
      begin_.push_back(static_cast<std::uint32_t>(i));
    });
    begin_.push_back(static_cast<std::uint32_t>(order_.size()));
  }

  std::size_t size() const { return cells_.size(); }

  std::uint32_t nearest_to_centre(std::size_t c) const {
    const auto middle = [&](std::int32_t index) { return (static_cast<double>(index) + 0.5) * resolution_; };
    const CellIndex index = keys_.cell(cells_[c]);
    const Vec3 centre{middle(index.x), middle(index.y), middle(index.z)};
    std::uint32_t nearest = 0;
    double smallest = std::numeric_limits<double>::infinity();
    for_each_voxel(c, [&](std::uint32_t v) {
      const Vec3 d = grid_.centroid[v] - centre;
      const double distance = dot(d, d);
      if (distance < smallest) smallest = distance, nearest = v;
      return true;
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
  /// each(v) for the voxels of cell c, ascending, until it returns false, or the work is stopped.
  template <typename Each>
  void for_each_voxel(std::size_t c, Each&& each) const {
    for (std::size_t i = begin_[c]; i < begin_[c + 1]; ++i) {
      const std::uint32_t first = run_[order_[i]], last = run_[order_[i] + 1];
      for (std::uint32_t v = first; v < last; ++v) {
        if (check_.after(1) || !each(v)) return;
      }
    }
  }

  /// Adds the voxels of cell c that are within the radius of v to the count, until it exceeds the limit.
  bool exceeds(std::size_t c, std::uint32_t v, double radius, double limit, double& count) const {
    bool more = false;
    for_each_voxel(c, [&](std::uint32_t u) {
      const Vec3 d = grid_.centroid[u] - grid_.centroid[v];
      more = dot(d, d) <= radius * radius && ++count > limit;
      return !more;
    });
    return more;
  }

  /// The first voxels of all runs, and after them the number of voxels; the cells of the runs.
  void find_runs(std::vector<CellIndex>& cell_of_run) {
    constexpr std::int32_t kLargest = std::numeric_limits<std::int32_t>::max();
    CellIndex low{kLargest, kLargest, kLargest}, high{-kLargest, -kLargest, -kLargest};
    run_.clear();
    cell_of_run.clear();
    check_.for_each(0, grid_.size(), [&](std::size_t v) {
      const CellIndex c = cell(grid_.centroid[v]);
      if (!cell_of_run.empty() && c == cell_of_run.back()) return;
      run_.push_back(static_cast<std::uint32_t>(v));
      cell_of_run.push_back(c);
      low = {std::min(low.x, c.x), std::min(low.y, c.y), std::min(low.z, c.z)};
      high = {std::max(high.x, c.x), std::max(high.y, c.y), std::max(high.z, c.z)};
    });
    run_.push_back(static_cast<std::uint32_t>(grid_.size()));
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
  std::vector<std::uint32_t>& run_;
  std::vector<std::uint32_t>& order_;  // of the runs, by cell
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
