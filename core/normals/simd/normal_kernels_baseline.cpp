// The kernels for every CPU of the architecture.
#define SEGSERVE_KERNELS plain_kernels
#include "core/normals/simd/normal_kernel_table.hpp"
