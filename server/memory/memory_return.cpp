// SPDX-License-Identifier: Apache-2.0
#include "server/memory/memory_return.hpp"

#include <malloc.h>
#include <unistd.h>

#include <algorithm>
#include <cstddef>
#include <cstdlib>
#include <fstream>

#include "spdlog/spdlog.h"

namespace segserve::server {
namespace {

constexpr std::chrono::seconds kBetweenLooks{5};
constexpr std::uint64_t kIdleLooks = 3;  // by then idle workers have given up their buffers, too
constexpr std::uint64_t kWorthwhile = std::uint64_t{8} << 20U;

constexpr int kTrimThreshold = 256 << 20;

}  // namespace

void keep_freed_memory() {
  mallopt(M_MMAP_THRESHOLD, 32 << 20);
  mallopt(M_TRIM_THRESHOLD, kTrimThreshold);
}

void give_back_own_memory() {
  // malloc looks at the end of an arena when a block of this size is freed, and gives back what exceeds the threshold.
  constexpr std::size_t kBlock = 256 << 10;
  mallopt(M_TRIM_THRESHOLD, kBlock);
  void* volatile block = std::malloc(kBlock);
  std::free(block);
  mallopt(M_TRIM_THRESHOLD, kTrimThreshold);
}

void MemoryReturn::on_tick(Time now) {
  if (now < next_look_) return;
  next_look_ = now + kBetweenLooks;
  idle_looks_ = ledger_.leased() == 0 ? idle_looks_ + 1 : 0;
  if (idle_looks_ < kIdleLooks) return;
  const std::uint64_t before = resident_memory();
  const bool has_just_become_idle = idle_looks_ == kIdleLooks;
  if (!has_just_become_idle && before < least_resident_ + kWorthwhile) return;
  malloc_trim(0);
  least_resident_ = resident_memory();
  spdlog::debug("gave {} MiB of memory back to the system", (before - std::min(before, least_resident_)) >> 20U);
}

std::uint64_t resident_memory() {
  std::ifstream statm("/proc/self/statm");  // SIZE RESIDENT .., in pages
  std::uint64_t size = 0, resident = 0;
  statm >> size >> resident;
  return resident * static_cast<std::uint64_t>(std::max(0L, sysconf(_SC_PAGESIZE)));
}

}  // namespace segserve::server
