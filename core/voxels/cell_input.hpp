// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>

#include "core/voxels/cell_mapping.hpp"
#include "core/voxels/point_selection.hpp"
#include "core/voxels/simd/voxel_kernels.hpp"
#include "segserve/cloud.hpp"

namespace segserve {

/// The input of the kernel find_cells for the points of the cloud from `first` on. All arguments must outlive it.
inline CellInput cell_input(const CloudView& cloud, const PointSelection& selection, const CellMapping& mapping,
                            std::size_t first) {
  return {cloud.x.data() + first,
          cloud.y.data() + first,
          cloud.z.data() + first,
          cloud.view.kind == ViewKind::kCamera,
          mapping.cells_per_meter,
          mapping.units_per_meter,
          mapping.elongation_depth,
          mapping.elongation_depth_logarithm,
          selection.all() ? nullptr : &selection.limits()};
}

}  // namespace segserve
