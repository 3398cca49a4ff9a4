// The kernels for x86-64 with AVX2; CMake compiles this file with -mavx2.
#define SEGSERVE_KERNELS avx2_kernels
#include "core/supervoxels/simd/growth_kernel_table.hpp"
