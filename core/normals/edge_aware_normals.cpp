#include "core/normals/edge_aware_normals.hpp"

#include <algorithm>

#include "core/base/parallel.hpp"
#include "core/base/stop_check.hpp"
#include "core/math/elementary.hpp"
#include "core/normals/normal_orientation.hpp"
#include "core/normals/two_ring_normals.hpp"

namespace segserve {
namespace {

/// work(groups) for some groups at a time, those of each part on a thread of its own.
template <typename Work>
absl::Status for_groups(const VoxelWindows& windows, const StopToken& stop, Work&& work) {
  constexpr std::size_t kMost = 16;
  const auto threads = static_cast<unsigned>(windows.parts.size());
  parallel_ranges(threads, threads, [&](std::size_t part, std::size_t) {
    const auto& [groups, spans] = windows.parts[part];
    StopCheck check(stop, threads);
    for (std::size_t first = 0; first < groups.size(); first += kMost) {
      const WindowGroup* const begin = groups.data() + first;
      const WindowGroup* const end = groups.data() + std::min(first + kMost, groups.size());
      std::uint64_t looked_at = 0;
      for (const WindowGroup* group = begin; group < end; ++group)
        looked_at += std::uint64_t{group->voxels.count} * group->candidates;
      if (check.after(looked_at)) return;
      work(WindowGroups{begin, end, spans.data()});
    }
  });
  return stop.check();
}

}  // namespace

absl::Status window_normals(const VoxelGrid& grid, const VoxelAdjacency& adjacency, const View& view,
                            const StopToken& stop, const VoxelWindows& windows, std::vector<Vec3>& normals) {
  const NormalKernels& kernels = normal_kernels();
  const WindowColumns columns = windows.columns();
  const Vec3 sensor = sensor_of(view);
  normals.resize(grid.size());
  const absl::Status status = for_groups(windows, stop, [&](const WindowGroups& groups) {
    kernels.fit_windows(columns, groups, normals.data());
    if (!view.has_sensor()) return;
    const std::uint32_t last = groups.end[-1].voxels.first + groups.end[-1].voxels.count;
    for (std::uint32_t v = groups.begin->voxels.first; v < last; ++v) {
      normals[v] = turn_to_sensor(normals[v], grid.centroid[v], sensor);
    }
  });
  return status.ok() && !view.has_sensor() ? orient_consistently(adjacency, stop, normals) : status;
}

absl::Status refine_normals(const EdgeAwareOptions& options, const StopToken& stop, VoxelWindows& windows,
                            std::vector<Vec3>& normals) {
  const NormalKernels& kernels = normal_kernels();
  const bool complete = StopCheck(stop).for_each(0, normals.size(), [&](std::size_t v) {
    windows.nx[v] = static_cast<float>(normals[v].x), windows.ny[v] = static_cast<float>(normals[v].y);
    windows.nz[v] = static_cast<float>(normals[v].z);
  });
  if (!complete) return stop.check();
  const double radians = options.angle * math::kDegree;
  const RefitScales scales{static_cast<float>(2 / (radians * radians)),
                           static_cast<float>(1 / (2 * options.offset * options.offset)),
                           static_cast<float>(options.support)};
  const WindowColumns columns = windows.columns();
  return for_groups(windows, stop, [&](const WindowGroups& groups) {
    kernels.refit_windows(columns, scales, groups, normals.data());
  });
}

}  // namespace segserve
