// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

namespace segserve {

/// An instruction set that the kernels (core/*/simd) are compiled for. The results are the same bytes with all of them.
enum class SimdTarget : std::uint8_t {
  kBaseline,  ///< what every CPU of the architecture has: SSE2 or NEON
  kAvx2,      ///< x86-64 with AVX2, BMI and POPCNT
};

/// The best target of this machine, which is found out once; kBaseline if SEGSERVE_CPU=any is in the environment.
SimdTarget best_simd_target();

/// The target whose kernels are used. It is `best_simd_target` until a test sets another one.
SimdTarget simd_target();
void set_simd_target(SimdTarget target);

}  // namespace segserve
