// SPDX-License-Identifier: Apache-2.0
// The kernels, compiled for one SimdTarget; see core/simd/simd_vectors.hpp.
#pragma once

#include "core/voxels/simd/cell_kernel.hpp"
#include "core/voxels/simd/run_kernel.hpp"

namespace segserve::SEGSERVE_SIMD_TARGET {

extern const VoxelKernels kVoxelKernels;
const VoxelKernels kVoxelKernels{find_cells, find_runs};

}  // namespace segserve::SEGSERVE_SIMD_TARGET
