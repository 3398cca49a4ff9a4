#include "segserve/voxel/edge_aware_normals.hpp"

#include <algorithm>
#include <array>
#include <span>
#include <utility>

#include "segserve/math/elementary.hpp"
#include "segserve/pipeline/parallel.hpp"
#include "segserve/voxel/kernels/kernels.hpp"
#include "segserve/voxel/voxel_blocks.hpp"

namespace segserve {
namespace {

/// The first `size` of these; the vector only grows, so that nothing is filled twice.
struct VoxelList {
  std::vector<std::uint32_t> voxels;
  std::size_t size = 0;

  std::uint32_t* room_for(std::size_t more) {
    if (size + more > voxels.size()) voxels.resize(2 * (size + more));
    return voxels.data() + size;
  }
};

/// Lists the distinct voxels within two steps of a voxel, itself left out: its neighbours, then the new ones of each.
class TwoRings {
 public:
  TwoRings(const VoxelAdjacency& adjacency, const std::vector<std::uint64_t>& patterns)
      : adjacency_(adjacency), patterns_(patterns) {}

  /// Appends those around v to the list and returns how many voxels it looked at.
  std::size_t append(std::uint32_t v, VoxelList& list) {
    std::uint32_t* const out = list.room_for(kMostTwoRings);
    const std::size_t found = patterns_[v] == 0 ? 0 : kernels_.two_rings(v, rows_, patterns_.data(), out);
    list.size += found;
    return found > 0 ? 1 + adjacency_.of(v).size() + found : append_any(v, list);
  }

 private:
  /// The same where the neighbours are not those of a grid, next to bridges.
  std::size_t append_any(std::uint32_t v, VoxelList& list) {
    const std::uint32_t mark = v + 1;
    const std::size_t begin = list.size;
    seen_.resize(patterns_.size());
    seen_[v] = mark;
    add(adjacency_.of(v), mark, list);
    const std::size_t first_ring = list.size;
    std::size_t visits = 1 + (first_ring - begin);
    for (std::size_t i = begin; i < first_ring; ++i) {
      const auto ring = adjacency_.of(list.voxels[i]);
      visits += ring.size();
      add(ring, mark, list);
    }
    return visits + (list.size - begin);
  }

  void add(std::span<const std::uint32_t> voxels, std::uint32_t mark, VoxelList& list) {
    std::uint32_t* const out = list.room_for(voxels.size());
    std::size_t found = 0;
    for (const std::uint32_t u : voxels) {
      if (std::exchange(seen_[u], mark) != mark) out[found++] = u;
    }
    list.size += found;
  }

  const VoxelKernels& kernels_ = voxel_kernels();
  const VoxelAdjacency& adjacency_;
  const NeighborRows rows_{adjacency_.offset.data(), adjacency_.neighbor.data()};
  const std::vector<std::uint64_t>& patterns_;
  std::vector<std::uint32_t> seen_;  // by whose list; made when it is needed
};

/// The tasks of some voxels, carried out together.
class Batch {
 public:
  Batch(const RefitInput& input, const VoxelAdjacency& adjacency, const std::vector<std::uint64_t>& patterns,
        std::vector<Vec3>& normals)
      : kernels_(voxel_kernels()), input_(input), rings_(adjacency, patterns), normals_(normals) {}

  /// Takes a voxel in; returns the work of it.
  std::size_t add(std::uint32_t v, double offset_scale) {
    begin_[tasks_] = list_.size;
    const std::size_t work = rings_.append(v, list_);
    task_[tasks_] = {v, nullptr, list_.size - begin_[tasks_], offset_scale};
    ++tasks_;
    std::fill_n(list_.room_for(kRefitPadding), kRefitPadding, v);
    list_.size += kRefitPadding;
    return work;
  }
  bool full() const { return tasks_ == kMost; }

  void carry_out() {
    for (std::size_t i = 0; i < tasks_; ++i) task_[i].neighbors = list_.voxels.data() + begin_[i];
    kernels_.refit(input_, task_.data(), tasks_, normals_.data());
    tasks_ = 0;
    list_.size = 0;
  }

 private:
  static constexpr std::size_t kMost = 32;

  const VoxelKernels& kernels_;
  const RefitInput& input_;
  TwoRings rings_;
  std::vector<Vec3>& normals_;
  VoxelList list_;
  std::array<RefitTask, kMost> task_;
  std::array<std::size_t, kMost> begin_;  // of each task in the list
  std::size_t tasks_ = 0;
};

}  // namespace

absl::Status refine_normals(const VoxelGrid& grid, const VoxelAdjacency& adjacency, const View& view,
                            double voxel_resolution, const EdgeAwareOptions& options, unsigned threads,
                            const StopToken& stop, NormalsScratch& scratch, std::vector<Vec3>& normals) {
  const NeighborRows rows{adjacency.offset.data(), adjacency.neighbor.data()};
  scratch.centroid.resize(grid.size());
  scratch.normal.resize(grid.size());
  for (std::size_t v = 0; v < grid.size(); ++v) {
    scratch.centroid[v] = quad(grid.centroid[v], 0);
    scratch.normal[v] = quad(normals[v], 0);
  }
  scratch.patterns.resize(grid.size());
  for_voxel_blocks(adjacency, threads, stop, [&](std::size_t first, std::size_t last) {
    voxel_kernels().neighbor_patterns(first, last, rows, grid.key.data(), scratch.patterns.data());
  });
  if (absl::Status status = stop.check(); !status.ok()) return status;
  const double radians = options.angle * math::kDegree;
  const RefitInput input{scratch.centroid.data(), scratch.normal.data(), 2 / (radians * radians), options.support};
  parallel_ranges(grid.size(), threads, [&](std::size_t begin, std::size_t end) {
    Batch batch(input, adjacency, scratch.patterns, normals);
    StopCheck check(stop, threads);
    for (std::size_t i = begin; i < end; ++i) {
      const auto v = static_cast<std::uint32_t>(i);
      if (check.after(1)) return;
      if (normals[v] == Vec3{}) continue;
      const double sigma = options.offset * voxel_edge(voxel_resolution, view, grid.centroid[v]);
      if (check.after(batch.add(v, 1 / (2 * sigma * sigma)))) return;
      if (batch.full()) batch.carry_out();
    }
    batch.carry_out();
  });
  return stop.check();
}

}  // namespace segserve
