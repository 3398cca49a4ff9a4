// The kernels for every CPU of the architecture.
#define SEGSERVE_KERNELS plain_kernels
#include "core/weights/simd/weight_kernel_table.hpp"
