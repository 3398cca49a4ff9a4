#pragma once

#include <cstdint>

namespace segserve {

/// Which instructions the inner loops may use. The results are the same bytes with all of them.
enum class Cpu : std::uint8_t {
  kAny,   ///< what every CPU of the architecture has: SSE2, NEON
  kAvx2,  ///< x86-64 with AVX2, and BMI and POPCNT, which all of those have
};

/// The best that this machine has, found out once; kAny if SEGSERVE_CPU=any is in the environment.
Cpu best_cpu();

/// What the inner loops use from now on. They start with `best_cpu`; tests compare the others with it.
void use_cpu(Cpu cpu);
Cpu cpu_in_use();

}  // namespace segserve
