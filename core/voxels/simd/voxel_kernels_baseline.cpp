// The kernels for every CPU of the architecture.
#define SEGSERVE_KERNELS plain_kernels
#include "core/voxels/simd/voxel_kernel_table.hpp"
