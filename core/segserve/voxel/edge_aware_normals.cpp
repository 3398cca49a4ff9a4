#include "segserve/voxel/edge_aware_normals.hpp"

#include <algorithm>
#include <array>

#include "segserve/math/elementary.hpp"
#include "segserve/pipeline/parallel.hpp"
#include "segserve/voxel/kernels/kernels.hpp"

namespace segserve {
namespace {

constexpr std::int64_t kReach = 2;  // cells
constexpr std::size_t kMostInSpan = RefitGroup::kMost + 2 * kReach;
static_assert(kMostInSpan <= kRefitPadding);
constexpr std::int64_t kLayer = std::int64_t{1} << kCellBits;
constexpr VoxelKey kCellMask = kLayer - 1;

/// Fills the columns. False: it was stopped.
bool lay_out(const VoxelGrid& grid, const std::vector<Vec3>& normals, const StopToken& stop, RefitScratch& s) {
  const std::size_t count = grid.size(), room = count + kRefitPadding;
  for (auto* column : {&s.x, &s.y, &s.z}) column->resize(room);
  for (auto* column : {&s.nx, &s.ny, &s.nz}) column->resize(room);
  s.cell_x.resize(room);
  s.key.resize(room);
  std::fill(s.key.begin() + static_cast<std::ptrdiff_t>(count), s.key.end(), kNoKey);
  s.row.clear();
  s.row_begin.clear();
  const bool complete = StopCheck(stop).for_each(0, count, [&](std::size_t v) {
    s.x[v] = grid.centroid[v].x, s.y[v] = grid.centroid[v].y, s.z[v] = grid.centroid[v].z;
    s.nx[v] = static_cast<float>(normals[v].x), s.ny[v] = static_cast<float>(normals[v].y);
    s.nz[v] = static_cast<float>(normals[v].z);
    s.cell_x[v] = static_cast<std::int32_t>(grid.key[v] & kCellMask);
    s.key[v] = grid.key[v];
    const VoxelKey row = grid.key[v] >> kCellBits;
    if (!s.row.empty() && s.row.back() == row) return;
    s.row.push_back(row);
    s.row_begin.push_back(static_cast<std::uint32_t>(v));
  });
  s.row_begin.push_back(static_cast<std::uint32_t>(count));
  return complete;
}

/// The voxels at most kReach cells away from those of a row, for consecutive rows and from left to right within each.
class NearbyRows {
 public:
  explicit NearbyRows(const RefitScratch& scratch) : s_(scratch) {}

  void enter(std::size_t row) {
    count_ = 0;
    for (std::int64_t dz = -kReach; dz <= kReach; ++dz) {
      const VoxelKey first = s_.row[row] + static_cast<VoxelKey>(dz * kLayer - kReach);
      std::size_t& next = layer_[static_cast<std::size_t>(dz + kReach)];
      while (next < s_.row.size() && s_.row[next] < first) ++next;
      for (std::size_t r = next; r < s_.row.size() && s_.row[r] <= first + 2 * kReach; ++r) {
        row_[count_++] = {s_.row[r] << kCellBits, s_.row_begin[r]};
      }
    }
  }

  /// Appends the voxels whose x is within [left, right], at most kMostInSpan cells; returns their number. Without
  /// branches but for gaps.
  std::size_t append(std::int32_t left, std::int32_t right, std::vector<RowSpan>& spans) {
    const std::size_t before = spans.size();
    spans.resize(before + kMostRowSpans);
    RowSpan* out = spans.data() + before;
    std::size_t found = 0;
    for (std::size_t i = 0; i < count_; ++i) {
      const VoxelKey first = row_[i].key + static_cast<VoxelKey>(left),
                     last = row_[i].key + static_cast<VoxelKey>(right);
      const VoxelKey* key = s_.key.data() + row_[i].next;
      key += count_if(key, [=](VoxelKey k) { return k < first; });
      while (*key < first) ++key;
      row_[i].next = static_cast<std::uint32_t>(key - s_.key.data());
      const std::uint32_t count = count_if(key, [=](VoxelKey k) { return k <= last; });
      *out = {row_[i].next, count};
      out += static_cast<std::ptrdiff_t>(count > 0);
      found += count;
    }
    spans.resize(static_cast<std::size_t>(out - spans.data()));
    return found;
  }

 private:
  struct Row {
    VoxelKey key;        // of its cell with x = 0
    std::uint32_t next;  // voxel
  };

  template <typename Predicate>
  static std::uint32_t count_if(const VoxelKey* key, Predicate&& predicate) {
    std::uint32_t count = 0;
#pragma GCC unroll 8
    for (std::size_t k = 0; k < kMostInSpan; ++k) count += static_cast<std::uint32_t>(predicate(key[k]));
    return count;
  }

  const RefitScratch& s_;
  std::array<std::size_t, 2 * kReach + 1> layer_{};  // the next row in the layers below and above
  std::array<Row, kMostRowSpans> row_;
  std::size_t count_ = 0;
};

/// Refits the voxels of some rows, many groups at a time.
class Refit {
 public:
  Refit(const RefitInput& input, const RefitScratch& scratch, std::vector<Vec3>& normals)
      : input_(input), s_(scratch), normals_(normals) {}

  /// offset_scale(v): RefitGroup::offset_scale of a voxel.
  template <typename OffsetScale>
  void rows(std::size_t first, std::size_t last, OffsetScale&& offset_scale, StopCheck& check) {
    NearbyRows nearby(s_);
    for (std::size_t row = first; row < last; ++row) {
      nearby.enter(row);
      if (check.after(1)) return;
      const std::uint32_t end = s_.row_begin[row + 1];
      // Groups depend on the row alone, and so do the lanes that a neighbour gets.
      for (std::uint32_t v = s_.row_begin[row]; v < end;) {
        RefitGroup& group = group_[groups_];
        group.voxels = {v, 0};
        const std::int32_t left = s_.cell_x[v];
        for (; v < end && s_.cell_x[v] < left + static_cast<std::int32_t>(RefitGroup::kMost); ++v) {
          group.offset_scale[group.voxels.count++] = offset_scale(v);
        }
        begin_[groups_] = spans_.size();
        const std::size_t found = nearby.append(left - kReach, s_.cell_x[v - 1] + kReach, spans_);
        group.span_count = spans_.size() - begin_[groups_++];
        if (check.after(group.voxels.count * (1 + found))) return;
        if (groups_ == kMost) carry_out();
      }
    }
    carry_out();
  }

 private:
  void carry_out() {
    for (std::size_t i = 0; i < groups_; ++i) group_[i].spans = spans_.data() + begin_[i];
    kernels_.refit(input_, group_.data(), groups_, normals_.data());
    groups_ = 0;
    spans_.clear();
  }

  static constexpr std::size_t kMost = 16;

  const VoxelKernels& kernels_ = voxel_kernels();
  const RefitInput& input_;
  const RefitScratch& s_;
  std::vector<Vec3>& normals_;
  std::vector<RowSpan> spans_;
  std::array<RefitGroup, kMost> group_;
  std::array<std::size_t, kMost> begin_;  // of each group in the spans
  std::size_t groups_ = 0;
};

}  // namespace

absl::Status refine_normals(const VoxelGrid& grid, const View& view, double voxel_resolution,
                            const EdgeAwareOptions& options, unsigned threads, const StopToken& stop,
                            NormalsScratch& scratch, std::vector<Vec3>& normals) {
  RefitScratch& s = scratch.refit;
  if (!lay_out(grid, normals, stop, s)) return stop.check();
  const double radians = options.angle * math::kDegree;
  const RefitInput input{s.x.data(),
                         s.y.data(),
                         s.z.data(),
                         s.nx.data(),
                         s.ny.data(),
                         s.nz.data(),
                         s.cell_x.data(),
                         static_cast<float>(2 / (radians * radians)),
                         static_cast<float>(options.support)};
  const auto offset_scale = [&](std::size_t v) {
    const double sigma = options.offset * voxel_edge(voxel_resolution, view, grid.centroid[v]);
    return static_cast<float>(1 / (2 * sigma * sigma));
  };
  const auto first_row_from = [&](std::size_t v) {
    return static_cast<std::size_t>(std::ranges::lower_bound(s.row_begin, v) - s.row_begin.begin());
  };
  parallel_ranges(grid.size(), threads, [&](std::size_t begin, std::size_t end) {
    StopCheck check(stop, threads);
    Refit(input, s, normals).rows(first_row_from(begin), first_row_from(end), offset_scale, check);
  });
  return stop.check();
}

}  // namespace segserve
