// SPDX-License-Identifier: Apache-2.0
#include "core/simd/simd_dispatch.hpp"

#include <atomic>
#include <cstdlib>
#include <string_view>

namespace segserve {
namespace {

SimdTarget find_best_target() {
  const char* const limit = std::getenv("SEGSERVE_CPU");
  if (limit != nullptr && std::string_view(limit) == "any") return SimdTarget::kBaseline;
#if defined(SEGSERVE_AVX2)
  if (__builtin_cpu_supports("avx2") && __builtin_cpu_supports("bmi") && __builtin_cpu_supports("bmi2") &&
      __builtin_cpu_supports("popcnt")) {
    return SimdTarget::kAvx2;
  }
#endif
  return SimdTarget::kBaseline;
}

std::atomic<SimdTarget>& current_target() {
  static std::atomic<SimdTarget> target = best_simd_target();
  return target;
}

}  // namespace

SimdTarget best_simd_target() {
  static const SimdTarget kBest = find_best_target();
  return kBest;
}

SimdTarget simd_target() { return current_target(); }
void set_simd_target(SimdTarget target) { current_target() = target; }

}  // namespace segserve
