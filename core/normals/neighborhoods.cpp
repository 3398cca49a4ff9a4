#include "core/normals/neighborhoods.hpp"

#include <algorithm>
#include <array>

#include "core/base/parallel.hpp"
#include "core/base/stop_check.hpp"

namespace segserve {
namespace {

constexpr std::int64_t kReach = kWindowReach;
static_assert(WindowGroup::kMost + std::size_t{2} * kWindowReach <= kWindowPadding, "a span is one load");
constexpr std::int64_t kLayer = std::int64_t{1} << kCellBits;  // between rows, from one z to the next
constexpr VoxelKey kCellMask = kLayer - 1;

/// Fills the columns but for the normals. False: it was stopped.
bool lay_out(const VoxelGrid& grid, const View& view, double voxel_resolution, const StopToken& stop, VoxelWindows& w) {
  const std::size_t count = grid.size(), room = count + kWindowPadding;
  for (auto* column : {&w.x, &w.y, &w.z}) column->resize(room);
  for (auto* column : {&w.nx, &w.ny, &w.nz, &w.inverse_square_edge}) column->resize(room);
  w.cell_x.resize(room);
  w.row.clear();
  w.row_begin.clear();
  const bool complete = StopCheck(stop).for_each(0, count, [&](std::size_t v) {
    const Vec3& centroid = grid.centroid[v];
    const double edge = voxel_edge(voxel_resolution, view, centroid);
    w.x[v] = centroid.x, w.y[v] = centroid.y, w.z[v] = centroid.z;
    w.inverse_square_edge[v] = static_cast<float>(1 / (edge * edge));
    w.cell_x[v] = static_cast<std::int32_t>(grid.key[v] & kCellMask);
    const VoxelKey row = grid.key[v] >> kCellBits;
    if (!w.row.empty() && w.row.back() == row) return;
    w.row.push_back(row);
    w.row_begin.push_back(static_cast<std::uint32_t>(v));
  });
  w.row_begin.push_back(static_cast<std::uint32_t>(count));
  return complete;
}

/// Finds the windows of consecutive rows, from left to right within each.
class WindowSearch {
 public:
  WindowSearch(const VoxelWindows& windows, VoxelWindows::Part& part) : w_(windows), part_(part) {
    part_.groups.clear();
  }

  void rows(std::size_t first, std::size_t last, StopCheck& check) {
    if (first < last) start(first);
    for (std::size_t row = first; row < last; ++row) {
      enter(row);
      if (check.after(nearby_)) return;
      // Groups depend on the row alone, and so do the lanes that a voxel gets in the sums.
      const std::uint32_t end = w_.row_begin[row + 1];
      for (std::uint32_t v = w_.row_begin[row]; v < end;) {
        const std::uint32_t first_of_group = v;
        const std::int32_t left = w_.cell_x[v], right = left + static_cast<std::int32_t>(WindowGroup::kMost);
        while (v < end && w_.cell_x[v] < right) ++v;
        add_group({first_of_group, v - first_of_group});
        if (check.after(nearby_)) return;
      }
    }
  }

 private:
  /// The first row that is near `row`, dz layers above it.
  VoxelKey first_near(std::size_t row, std::int64_t dz) const {
    return w_.row[row] + static_cast<VoxelKey>(dz * kLayer - kReach);
  }

  void start(std::size_t row) {
    for (std::int64_t dz = -kReach; dz <= kReach; ++dz) {
      const auto found = std::ranges::lower_bound(w_.row, first_near(row, dz));
      layer_[static_cast<std::size_t>(dz + kReach)] = static_cast<std::size_t>(found - w_.row.begin());
    }
  }

  /// Goes to the next row: finds the rows with voxels near it.
  void enter(std::size_t row) {
    nearby_ = 0;
    for (std::int64_t dz = -kReach; dz <= kReach; ++dz) {
      const VoxelKey first = first_near(row, dz);
      std::size_t& next = layer_[static_cast<std::size_t>(dz + kReach)];
      while (next < w_.row.size() && w_.row[next] < first) ++next;
      for (std::size_t r = next; r < w_.row.size() && w_.row[r] <= first + 2 * kReach; ++r) {
        row_[nearby_++] = {w_.row_begin[r], w_.row_begin[r + 1]};
      }
    }
  }

  void add_group(const RowSpan& voxels) {
    if (part_.spans.size() < spans_ + kMostRowSpans) part_.spans.resize(2 * spans_ + 1024 * kMostRowSpans);
    const std::int32_t left = w_.cell_x[voxels.first] - kWindowReach,
                       right = w_.cell_x[voxels.first + voxels.count - 1] + kWindowReach;
    const SpanCount found =
        kernels_.find_spans(w_.cell_x.data(), left, right, row_.data(), nearby_, part_.spans.data() + spans_);
    part_.groups.push_back({voxels, static_cast<std::uint32_t>(spans_), found.spans, found.voxels});
    spans_ += found.spans;
  }

  const NormalKernels& kernels_ = normal_kernels();
  const VoxelWindows& w_;
  VoxelWindows::Part& part_;
  std::size_t spans_ = 0;
  std::array<std::size_t, 2 * kReach + 1> layer_{};  // the next row in the layers below and above
  std::array<CellRow, kMostRowSpans> row_;
  std::size_t nearby_ = 0;
};

}  // namespace

absl::Status find_windows(const VoxelGrid& grid, const View& view, double voxel_resolution, unsigned threads,
                          const StopToken& stop, VoxelWindows& windows) {
  if (!lay_out(grid, view, voxel_resolution, stop, windows)) return stop.check();
  windows.parts.resize(threads);
  const auto first_row_from = [&](std::size_t v) {
    return static_cast<std::size_t>(std::ranges::lower_bound(windows.row_begin, v) - windows.row_begin.begin());
  };
  parallel_parts(grid.size(), threads, [&](unsigned part, std::size_t begin, std::size_t end) {
    StopCheck check(stop, threads);
    WindowSearch(windows, windows.parts[part]).rows(first_row_from(begin), first_row_from(end), check);
  });
  return stop.check();
}

}  // namespace segserve
