// The kernels for every CPU of the architecture.
#define SEGSERVE_KERNELS plain_kernels
#include "core/supervoxels/simd/growth_kernel_table.hpp"
