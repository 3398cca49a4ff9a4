// SPDX-License-Identifier: Apache-2.0
#include "server/memory/memory_ledger.hpp"

#include <unistd.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <limits>
#include <string>

namespace segserve::server {
namespace {

constexpr std::uint64_t kUnlimited = std::numeric_limits<std::uint64_t>::max();

/// The number in a file such as memory.max; kUnlimited if there is none.
std::uint64_t limit_in(const std::filesystem::path& file) {
  std::ifstream in(file);
  std::uint64_t limit = 0;
  return in >> limit ? limit : kUnlimited;
}

/// The least limit of the cgroup `path` below `root` and of those that hold it.
std::uint64_t least_limit(const std::filesystem::path& root, std::filesystem::path path, const char* file) {
  std::uint64_t least = limit_in(root / file);
  for (path = path.relative_path(); !path.empty(); path = path.parent_path()) {
    least = std::min(least, limit_in(root / path / file));
  }
  return least;
}

std::uint64_t cgroup_limit() {
  std::uint64_t least = kUnlimited;
  std::ifstream groups("/proc/self/cgroup");
  for (std::string line; std::getline(groups, line);) {  // HIERARCHY:CONTROLLERS:PATH
    const std::size_t first = line.find(':'), second = line.find(':', first + 1);
    if (second == std::string::npos) continue;
    const std::string controllers = line.substr(first + 1, second - first - 1), path = line.substr(second + 1);
    if (controllers.empty()) {
      least = std::min(least, least_limit("/sys/fs/cgroup", path, "memory.max"));
    } else if (controllers == "memory") {
      least = std::min(least, least_limit("/sys/fs/cgroup/memory", path, "memory.limit_in_bytes"));
    }
  }
  return least;
}

}  // namespace

MemoryLease& MemoryLease::operator=(MemoryLease&& other) noexcept {
  if (this != &other) {
    release();
    ledger_ = std::exchange(other.ledger_, nullptr);
    bytes_ = other.bytes_;
  }
  return *this;
}

bool MemoryLease::resize(std::uint64_t bytes) {
  if (ledger_ == nullptr || !ledger_->change(bytes_, bytes)) return false;
  bytes_ = bytes;
  return true;
}

void MemoryLease::release() {
  if (ledger_ != nullptr) ledger_->change(bytes_, 0);
  ledger_ = nullptr;
}

std::optional<MemoryLease> MemoryLedger::lease(std::uint64_t bytes) {
  if (!change(0, bytes)) return std::nullopt;
  return MemoryLease(*this, bytes);
}

std::uint64_t MemoryLedger::leased() const {
  const MutexLock lock(mutex_);
  return leased_;
}

bool MemoryLedger::change(std::uint64_t before, std::uint64_t after) {
  const MutexLock lock(mutex_);
  const std::uint64_t others = leased_ - before;
  if (after > before && (others > budget_ || after > budget_ - others)) return false;
  leased_ = others + after;
  return true;
}

std::uint64_t available_memory() {
  const auto pages = static_cast<std::uint64_t>(std::max(0L, sysconf(_SC_PHYS_PAGES)));
  const auto page_bytes = static_cast<std::uint64_t>(std::max(0L, sysconf(_SC_PAGESIZE)));
  return std::min(cgroup_limit(), pages * page_bytes);
}

}  // namespace segserve::server
