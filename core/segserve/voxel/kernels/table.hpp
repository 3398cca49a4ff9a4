// Part of the kernels; see math/lanes.hpp.
#pragma once

#include "segserve/voxel/kernels/cells.hpp"
#include "segserve/voxel/kernels/moments.hpp"
#include "segserve/voxel/kernels/runs.hpp"
#include "segserve/voxel/kernels/spans.hpp"
#include "segserve/voxel/kernels/windows.hpp"

namespace segserve::SEGSERVE_KERNELS {

extern const VoxelKernels kVoxelKernels;
const VoxelKernels kVoxelKernels{find_cells, find_runs,   ring_moments, fit_planes,
                                 find_spans, fit_windows, refit_windows};

}  // namespace segserve::SEGSERVE_KERNELS
