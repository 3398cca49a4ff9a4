// SPDX-License-Identifier: Apache-2.0
#include "core/normals/edge_aware_normals.hpp"

#include <algorithm>

#include "core/base/parallel_parts.hpp"
#include "core/base/status_macros.hpp"
#include "core/base/stop_check.hpp"
#include "core/math/elementary.hpp"
#include "core/normals/normal_orientation.hpp"

namespace segserve {
namespace {

/// Calls work(groups) for some groups of voxels at a time, each part on a thread of its own.
template <typename Work>
absl::Status for_groups(const FrameContext& frame, const Neighborhoods& neighborhoods, Work&& work) {
  constexpr std::size_t kMost = 16;
  const auto work_on_part = [&](const Neighborhoods::Part& part, StopCheck& check) {
    const auto& [groups, spans] = part;
    for (std::size_t first = 0; first < groups.size(); first += kMost) {
      const VoxelGroup* const begin = groups.data() + first;
      const VoxelGroup* const end = groups.data() + std::min(first + kMost, groups.size());
      std::uint64_t visits = 0;
      for (const VoxelGroup* group = begin; group < end; ++group) {
        visits += std::uint64_t{group->voxels.count} * group->candidates;
      }
      if (check.after(visits)) return;
      work(VoxelGroups{begin, end, spans.data()});
    }
  };
  return parallel_parts(frame.executor, frame.stop, neighborhoods.parts.size(),
                        [&](unsigned, std::size_t begin, std::size_t end, StopCheck& check) {
                          for (std::size_t p = begin; p < end; ++p) work_on_part(neighborhoods.parts[p], check);
                        });
}

}  // namespace

absl::Status EdgeAwareNormals::run(const FrameContext& frame, const VoxelGrid& grid, const VoxelAdjacency& adjacency,
                                   std::vector<Vec3>& normals) {
  RETURN_IF_ERROR(find_neighborhoods(frame, grid, neighborhoods_));
  RETURN_IF_ERROR(fit_neighborhood_normals(frame, grid, adjacency, neighborhoods_, normals));
  if (frame.view().sensor) RETURN_IF_ERROR(orient_hidden_normals(frame, grid, adjacency, normals));
  return refine_normals(frame, {}, neighborhoods_, normals);
}

absl::Status fit_neighborhood_normals(const FrameContext& frame, const VoxelGrid& grid, const VoxelAdjacency& adjacency,
                                      const Neighborhoods& neighborhoods, std::vector<Vec3>& normals) {
  const NormalKernels& kernels = normal_kernels();
  const VoxelColumns columns = neighborhoods.columns();
  normals.resize(grid.size());
  RETURN_IF_ERROR(for_groups(frame, neighborhoods, [&](const VoxelGroups& groups) {
    kernels.fit_neighborhoods(columns, groups, normals.data());
    const std::uint32_t last = groups.end[-1].voxels.first + groups.end[-1].voxels.count;
    turn_to_sensors(frame, grid, groups.begin->voxels.first, last, normals);
  }));
  return frame.view().has_sensor() ? absl::OkStatus() : orient_as_seen(frame, grid, adjacency, normals);
}

absl::Status refine_normals(const FrameContext& frame, const RefinementOptions& options, Neighborhoods& neighborhoods,
                            std::vector<Vec3>& normals) {
  const NormalKernels& kernels = normal_kernels();
  StopCheck check(frame.stop);
  check.for_each(0, normals.size(), [&](std::size_t v) {
    neighborhoods.nx[v] = static_cast<float>(normals[v].x);
    neighborhoods.ny[v] = static_cast<float>(normals[v].y);
    neighborhoods.nz[v] = static_cast<float>(normals[v].z);
  });
  RETURN_IF_ERROR(check.status());
  const double radians = options.angle * math::kDegree;
  const RefitScales scales{static_cast<float>(2 / (radians * radians)),
                           static_cast<float>(1 / (2 * options.offset * options.offset)),
                           static_cast<float>(options.support)};
  const VoxelColumns columns = neighborhoods.columns();
  return for_groups(frame, neighborhoods, [&](const VoxelGroups& groups) {
    kernels.refit_neighborhoods(columns, scales, groups, normals.data());
  });
}

}  // namespace segserve
