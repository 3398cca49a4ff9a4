// SPDX-License-Identifier: Apache-2.0
// The kernels for x86-64 with AVX2. CMake compiles this file with -mavx2.
#define SEGSERVE_SIMD_TARGET avx2
#include "core/weights/simd/weight_kernel_table.hpp"
