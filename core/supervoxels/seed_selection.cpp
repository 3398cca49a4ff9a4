// SPDX-License-Identifier: Apache-2.0
#include "core/supervoxels/seed_selection.hpp"

#include <algorithm>
#include <bit>
#include <limits>

#include "core/base/radix_sort.hpp"
#include "core/base/stop_check.hpp"
#include "core/math/elementary.hpp"

namespace segserve {
namespace {

/// Maps the cells between two corners of the grid to keys that sort by z, then y, then x. The keys have as few bits as
/// the corners allow, because the sort takes a pass for every few bits.
class CellKeys {
 public:
  CellKeys() = default;
  CellKeys(const SeedCell& low, const SeedCell& high) : low_(low), high_(high) {
    x_bits_ = width(low.x, high.x);
    y_bits_ = width(low.y, high.y);
  }

  std::uint64_t key(const SeedCell& c) const {
    return offset(low_.z, c.z) << (x_bits_ + y_bits_) | offset(low_.y, c.y) << x_bits_ | offset(low_.x, c.x);
  }
  SeedCell cell(std::uint64_t key) const {
    const auto part = [&](int shift, int bits) {
      return static_cast<std::int32_t>(key >> shift & ((std::uint64_t{1} << bits) - 1));
    };
    return {low_.x + part(0, x_bits_), low_.y + part(x_bits_, y_bits_), low_.z + part(x_bits_ + y_bits_, 31)};
  }
  bool has_row(const SeedCell& c) const { return c.y >= low_.y && c.y <= high_.y && c.z >= low_.z && c.z <= high_.z; }
  std::int32_t clamp_x(std::int32_t x) const { return std::clamp(x, low_.x, high_.x); }

 private:
  static std::uint64_t offset(std::int32_t low, std::int32_t c) {
    return static_cast<std::uint64_t>(std::int64_t{c} - std::int64_t{low});
  }
  static int width(std::int32_t low, std::int32_t high) { return static_cast<int>(std::bit_width(offset(low, high))); }

  SeedCell low_{}, high_{};
  int x_bits_ = 0, y_bits_ = 0;
};

/// The voxels by the seed cell that holds their centroid.
class VoxelsByCell {
 public:
  VoxelsByCell(const std::vector<Vec3>& positions, double resolution, SeedSelection::Scratch& scratch, StopCheck& check)
      : positions_(positions), resolution_(resolution), check_(check), s_(scratch) {
    find_runs();
    s_.key_of_run.resize(s_.cell_of_run.size());
    check_.for_each(0, s_.key_of_run.size(), [&](std::size_t r) { s_.key_of_run[r] = keys_.key(s_.cell_of_run[r]); });
    math::sort_order(s_.key_of_run, s_.order, s_.sort, check_);
    find_cells();
  }

  std::size_t cell_count() const { return s_.cell_key.size(); }

  std::uint32_t nearest_to_center(std::size_t c) const {
    const auto middle = [&](std::int32_t index) { return (static_cast<double>(index) + 0.5) * resolution_; };
    const SeedCell cell = keys_.cell(s_.cell_key[c]);
    const Vec3 center{middle(cell.x), middle(cell.y), middle(cell.z)};
    std::uint32_t nearest = 0;
    double smallest = std::numeric_limits<double>::infinity();
    for_each_voxel(c, [&](std::uint32_t v) {
      const Vec3 d = positions_[v] - center;
      const double distance = dot(d, d);
      if (distance < smallest) smallest = distance, nearest = v;
      return true;
    });
    return nearest;
  }

  /// Whether more than `limit` voxels, v included, have their centroids within `radius` of that of v, a voxel of cell
  /// c. The radius is at most the resolution. Mostly the cell alone has enough, which saves the search for others.
  bool more_within(std::size_t c, std::uint32_t v, double radius, double limit) const {
    double count = 0;
    if (exceeds(c, v, radius, limit, count)) return true;
    count = 0;
    const Vec3& middle = positions_[v];
    for (double dz : {-radius, radius}) {
      for (double dy : {-radius, radius}) {
        if (is_repeated_row(middle, radius, dy, dz)) continue;
        const SeedCell row = cell_at(middle + Vec3{-radius, dy, dz});
        if (!keys_.has_row(row)) continue;
        const std::uint64_t first = keys_.key({keys_.clamp_x(row.x), row.y, row.z});
        const std::uint64_t last = keys_.key({keys_.clamp_x(index_at(middle.x + radius)), row.y, row.z});
        for (auto o = static_cast<std::size_t>(std::ranges::lower_bound(s_.cell_key, first) - s_.cell_key.begin());
             o < s_.cell_key.size() && s_.cell_key[o] <= last; ++o) {
          if (exceeds(o, v, radius, limit, count)) return true;
        }
      }
    }
    return false;
  }

 private:
  void find_runs() {
    constexpr std::int32_t kLargest = std::numeric_limits<std::int32_t>::max();
    SeedCell low{kLargest, kLargest, kLargest}, high{-kLargest, -kLargest, -kLargest};
    s_.run_begin.clear();
    s_.cell_of_run.clear();
    check_.for_each(0, positions_.size(), [&](std::size_t v) {
      const SeedCell c = cell_at(positions_[v]);
      if (!s_.cell_of_run.empty() && c == s_.cell_of_run.back()) return;
      s_.run_begin.push_back(static_cast<std::uint32_t>(v));
      s_.cell_of_run.push_back(c);
      low = {std::min(low.x, c.x), std::min(low.y, c.y), std::min(low.z, c.z)};
      high = {std::max(high.x, c.x), std::max(high.y, c.y), std::max(high.z, c.z)};
    });
    s_.run_begin.push_back(static_cast<std::uint32_t>(positions_.size()));
    if (low.x <= high.x) keys_ = CellKeys(low, high);
  }

  void find_cells() {
    s_.cell_key.clear();
    s_.cell_begin.clear();
    check_.for_each(0, s_.order.size(), [&](std::size_t i) {
      const std::uint64_t key = s_.key_of_run[s_.order[i]];
      if (!s_.cell_key.empty() && s_.cell_key.back() == key) return;
      s_.cell_key.push_back(key);
      s_.cell_begin.push_back(static_cast<std::uint32_t>(i));
    });
    s_.cell_begin.push_back(static_cast<std::uint32_t>(s_.order.size()));
  }

  /// Calls each(v) for the voxels of cell c, ascending, until it returns false or the work is stopped.
  template <typename Each>
  void for_each_voxel(std::size_t c, Each&& each) const {
    for (std::size_t i = s_.cell_begin[c]; i < s_.cell_begin[c + 1]; ++i) {
      const std::uint32_t first = s_.run_begin[s_.order[i]], last = s_.run_begin[s_.order[i] + 1];
      for (std::uint32_t v = first; v < last; ++v) {
        if (check_.after(1) || !each(v)) return;
      }
    }
  }

  /// Counts the voxels of cell c within the radius of v, until `count` exceeds the limit. Returns whether it does.
  bool exceeds(std::size_t c, std::uint32_t v, double radius, double limit, double& count) const {
    bool more = false;
    for_each_voxel(c, [&](std::uint32_t u) {
      const Vec3 d = positions_[u] - positions_[v];
      more = dot(d, d) <= radius * radius && ++count > limit;
      return !more;
    });
    return more;
  }

  SeedCell cell_at(const Vec3& p) const { return {index_at(p.x), index_at(p.y), index_at(p.z)}; }
  std::int32_t index_at(double meters) const { return math::floor_to_int(meters / resolution_); }

  /// The ball around `middle` reaches into at most two rows of cells in each direction. Where both ends lie in one row,
  /// that is visited only from the lower end.
  bool is_repeated_row(const Vec3& middle, double radius, double dy, double dz) const {
    return (dy > 0 && index_at(middle.y - radius) == index_at(middle.y + radius)) ||
           (dz > 0 && index_at(middle.z - radius) == index_at(middle.z + radius));
  }

  const std::vector<Vec3>& positions_;
  double resolution_;
  StopCheck& check_;
  SeedSelection::Scratch& s_;
  CellKeys keys_;
};

}  // namespace

absl::Status SeedSelection::run(const FrameContext& frame, const std::vector<Vec3>& positions, Seeds& seeds) {
  seeds.chosen.clear();
  seeds.sparse.clear();
  StopCheck check(frame.stop);
  const VoxelsByCell cells(positions, frame.scale.seed, scratch_, check);
  const double radius = 0.5 * frame.scale.seed;
  for (std::size_t c = 0; c < cells.cell_count() && !check.after(1); ++c) {
    const std::uint32_t seed = cells.nearest_to_center(c);
    const double edge =
        frame.scale.in_proportion ? frame.scale.voxel : voxel_edge(frame.scale, frame.view(), positions[seed]);
    const double voxels_of_disc = math::kPi * radius * radius / (edge * edge);
    (cells.more_within(c, seed, radius, 0.05 * voxels_of_disc) ? seeds.chosen : seeds.sparse).push_back(seed);
  }
  return check.status();
}

}  // namespace segserve
