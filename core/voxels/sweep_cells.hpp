// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>

#include "core/math/vec3.hpp"
#include "core/voxels/cell_mapping.hpp"
#include "core/voxels/point_selection.hpp"
#include "core/voxels/simd/voxel_kernels.hpp"

namespace segserve {

/// Whether a point of a sweep is so close to the sensor that it is no measurement.
bool is_without_echo(const VoxelScale& scale, const Vec3& point);

/// Finds the cells of points in a LiDAR's sweep (VoxelScale::sweep), as the kernel find_cells does in other clouds:
/// cells are cubes of to_voxel_space. A point without an echo counts as a zero. There must be room for `count` points
/// in `out`.
PointsWithoutCell find_sweep_cells(const CellInput& in, const CellMapping& mapping, const PointSelection& selection,
                                   std::size_t count, const CellOutput& out);

}  // namespace segserve
