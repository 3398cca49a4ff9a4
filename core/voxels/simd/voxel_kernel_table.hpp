// Part of the kernels; see core/simd/simd_vectors.hpp.
#pragma once

#include "core/voxels/simd/cell_kernel.hpp"
#include "core/voxels/simd/run_kernel.hpp"

namespace segserve::SEGSERVE_KERNELS {

extern const VoxelKernels kVoxelKernels;
const VoxelKernels kVoxelKernels{find_cells, find_runs};

}  // namespace segserve::SEGSERVE_KERNELS
