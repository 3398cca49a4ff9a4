// SPDX-License-Identifier: Apache-2.0
// The kernels for every CPU of the architecture.
#define SEGSERVE_SIMD_TARGET baseline
#include "core/voxels/simd/voxel_kernel_table.hpp"
