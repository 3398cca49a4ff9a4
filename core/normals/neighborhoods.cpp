// SPDX-License-Identifier: Apache-2.0
#include "core/normals/neighborhoods.hpp"

#include <algorithm>
#include <array>

#include "core/base/parallel_parts.hpp"
#include "core/base/status_macros.hpp"
#include "core/base/stop_check.hpp"

namespace segserve {
namespace {

constexpr std::int64_t kReach = kNeighborhoodReach;
static_assert(VoxelGroup::kMost + std::size_t{2} * kNeighborhoodReach <= kColumnPadding, "a span is one load");
constexpr std::int64_t kLayer = std::int64_t{1} << kCellBits;  // between rows, from one z to the next
constexpr VoxelKey kCellMask = kLayer - 1;

/// Fills the columns except for the normals, for which it makes room.
/// The edge, meters, against which distances from a plane count. Voxels of a camera are deeper than wide because of its
/// noise. Those of a sweep are so where it sees surfaces at grazing angles, and its ranges have centimeters of noise.
double fitting_edge(const FrameContext& frame, const Vec3& centroid) {
  constexpr double kLeastOfSweep = 0.3;  // meters
  const double edge = voxel_edge(frame.scale, frame.view(), centroid);
  if (frame.scale.sweep) return std::max(kLeastOfSweep, edge);
  return edge * frame.scale.elongation(centroid.z);
}

absl::Status fill_columns(const FrameContext& frame, const VoxelGrid& grid, Neighborhoods& n) {
  const std::size_t count = grid.size(), room = count + kColumnPadding;
  for (auto* column : {&n.x, &n.y, &n.z}) column->resize(room);
  for (auto* column : {&n.nx, &n.ny, &n.nz, &n.inverse_square_edge}) column->resize(room);
  n.cell_x.resize(room);
  n.row.clear();
  n.row_begin.clear();
  StopCheck check(frame.stop);
  check.for_each(0, count, [&](std::size_t v) {
    const Vec3& centroid = grid.centroid[v];
    const double edge = fitting_edge(frame, centroid);
    n.x[v] = centroid.x, n.y[v] = centroid.y, n.z[v] = centroid.z;
    n.inverse_square_edge[v] = static_cast<float>(1 / (edge * edge));
    n.cell_x[v] = static_cast<std::int32_t>(grid.key[v] & kCellMask);
    const VoxelKey row = grid.key[v] >> kCellBits;
    if (!n.row.empty() && n.row.back() == row) return;
    n.row.push_back(row);
    n.row_begin.push_back(static_cast<std::uint32_t>(v));
  });
  n.row_begin.push_back(static_cast<std::uint32_t>(count));
  return check.status();
}

/// Finds the neighborhoods of the voxels of consecutive rows, from left to right within each row.
class NeighborhoodSearch {
 public:
  NeighborhoodSearch(const Neighborhoods& all, Neighborhoods::Part& part) : all_(all), part_(part) {
    part_.groups.clear();
  }

  void rows(std::size_t first, std::size_t last, StopCheck& check) {
    if (first < last) start(first);
    for (std::size_t row = first; row < last; ++row) {
      enter(row);
      if (check.after(nearby_)) return;
      // Groups depend on the row alone, and so do the lanes in which the kernels add up the voxels.
      const std::uint32_t end = all_.row_begin[row + 1];
      for (std::uint32_t v = all_.row_begin[row]; v < end;) {
        const std::uint32_t first_of_group = v;
        const std::int32_t left = all_.cell_x[v], right = left + static_cast<std::int32_t>(VoxelGroup::kMost);
        while (v < end && all_.cell_x[v] < right) ++v;
        add_group({first_of_group, v - first_of_group});
        if (check.after(nearby_)) return;
      }
    }
  }

 private:
  /// The key of the first row near `row` in the layer that is dz above it.
  VoxelKey first_near(std::size_t row, std::int64_t dz) const {
    return all_.row[row] + static_cast<VoxelKey>(dz * kLayer - kReach);
  }

  void start(std::size_t row) {
    for (std::int64_t dz = -kReach; dz <= kReach; ++dz) {
      const auto found = std::ranges::lower_bound(all_.row, first_near(row, dz));
      layer_[static_cast<std::size_t>(dz + kReach)] = static_cast<std::size_t>(found - all_.row.begin());
    }
  }

  /// Finds the rows with voxels near `row`, the next one.
  void enter(std::size_t row) {
    nearby_ = 0;
    for (std::int64_t dz = -kReach; dz <= kReach; ++dz) {
      const VoxelKey first = first_near(row, dz);
      std::size_t& next = layer_[static_cast<std::size_t>(dz + kReach)];
      while (next < all_.row.size() && all_.row[next] < first) ++next;
      for (std::size_t r = next; r < all_.row.size() && all_.row[r] <= first + 2 * kReach; ++r) {
        row_[nearby_++] = {all_.row_begin[r], all_.row_begin[r + 1]};
      }
    }
  }

  void add_group(const RowSpan& voxels) {
    if (part_.spans.size() < spans_ + kMostRowSpans) part_.spans.resize(2 * spans_ + 1024 * kMostRowSpans);
    const std::int32_t left = all_.cell_x[voxels.first] - kNeighborhoodReach,
                       right = all_.cell_x[voxels.first + voxels.count - 1] + kNeighborhoodReach;
    const SpanCount found =
        kernels_.find_spans(all_.cell_x.data(), left, right, row_.data(), nearby_, part_.spans.data() + spans_);
    part_.groups.push_back({voxels, static_cast<std::uint32_t>(spans_), found.spans, found.voxels});
    spans_ += found.spans;
  }

  const NormalKernels& kernels_ = normal_kernels();
  const Neighborhoods& all_;
  Neighborhoods::Part& part_;
  std::size_t spans_ = 0;
  std::array<std::size_t, 2 * kReach + 1> layer_{};  // the next row in each layer
  std::array<CellRow, kMostRowSpans> row_;
  std::size_t nearby_ = 0;
};

}  // namespace

absl::Status find_neighborhoods(const FrameContext& frame, const VoxelGrid& grid, Neighborhoods& neighborhoods) {
  RETURN_IF_ERROR(fill_columns(frame, grid, neighborhoods));
  neighborhoods.parts.resize(frame.executor.threads());
  const auto first_row_from = [&](std::size_t v) {
    const auto row = std::ranges::lower_bound(neighborhoods.row_begin, v);
    return static_cast<std::size_t>(row - neighborhoods.row_begin.begin());
  };
  return parallel_parts(frame.executor, frame.stop, grid.size(),
                        [&](unsigned part, std::size_t begin, std::size_t end, StopCheck& check) {
                          NeighborhoodSearch search(neighborhoods, neighborhoods.parts[part]);
                          search.rows(first_row_from(begin), first_row_from(end), check);
                        });
}

}  // namespace segserve
