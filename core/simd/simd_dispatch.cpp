#include "core/simd/simd_dispatch.hpp"

#include <atomic>
#include <cstdlib>
#include <string_view>

namespace segserve {
namespace {

Cpu find_best_cpu() {
  const char* const limit = std::getenv("SEGSERVE_CPU");
  if (limit != nullptr && std::string_view(limit) == "any") return Cpu::kAny;
#if defined(SEGSERVE_AVX2)
  if (__builtin_cpu_supports("avx2") && __builtin_cpu_supports("bmi") && __builtin_cpu_supports("bmi2") &&
      __builtin_cpu_supports("popcnt")) {
    return Cpu::kAvx2;
  }
#endif
  return Cpu::kAny;
}

std::atomic<Cpu>& in_use() {
  static std::atomic<Cpu> cpu = best_cpu();
  return cpu;
}

}  // namespace

Cpu best_cpu() {
  static const Cpu kBest = find_best_cpu();
  return kBest;
}

void use_cpu(Cpu cpu) { in_use() = cpu; }
Cpu cpu_in_use() { return in_use(); }

}  // namespace segserve
