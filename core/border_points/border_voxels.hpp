// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "absl/status/status.h"
#include "core/base/frame_context.hpp"
#include "core/region_graph/region_graph.hpp"
#include "core/supervoxels/supervoxel_growth.hpp"
#include "core/weights/border_metric.hpp"

namespace segserve {

/// The voxels that lie at a border between two objects: those with a neighbor in a supervoxel that the evidence holds
/// to be another object.
struct BorderVoxels {
  std::vector<std::uint32_t> begin;     ///< V + 1: where the entries of each voxel begin in `opposite`
  std::vector<std::uint32_t> opposite;  ///< the supervoxels across the border, ascending for each voxel

  std::size_t size() const { return begin.empty() ? 0 : begin.size() - 1; }
  /// The supervoxels across the border from voxel v. There are none if it does not lie at a border.
  std::span<const std::uint32_t> opposite_of(std::size_t v) const {
    return std::span(opposite).subspan(begin[v], begin[v + 1] - begin[v]);
  }
};

/// Finds the voxels at the edges whose mean evidence is at least that at which two small regions are as likely one
/// object as two (BorderConstants::bias). `evidence` has an entry for each edge of the graph. O(V + C log C) for V
/// voxels and C contacts across such edges. CANCELLED, DEADLINE_EXCEEDED.
absl::Status find_border_voxels(const FrameContext& frame, const Supervoxels& supervoxels, const RegionGraph& graph,
                                const std::vector<BorderEvidence>& evidence, BorderVoxels& border);

}  // namespace segserve
