// Part of the kernels; see math/lanes.hpp.
#pragma once

#include "segserve/voxel/kernels/cells.hpp"
#include "segserve/voxel/kernels/moments.hpp"
#include "segserve/voxel/kernels/refit.hpp"
#include "segserve/voxel/kernels/runs.hpp"

namespace segserve::SEGSERVE_KERNELS {

extern const VoxelKernels kVoxelKernels;
const VoxelKernels kVoxelKernels{find_cells, find_runs, ring_moments, fit_planes, refit};

}  // namespace segserve::SEGSERVE_KERNELS
