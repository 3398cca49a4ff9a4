// SPDX-License-Identifier: Apache-2.0
#include "server/memory/memory_ledger.hpp"

#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <filesystem>
#include <fstream>
#include <limits>
#include <string>

namespace segserve::server {
namespace {

// How long a client that was refused counts as one that waits. Refusals tell it to come again earlier than that.
constexpr std::chrono::seconds kRefusedFor{5};
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

MemoryLease::MemoryLease(MemoryLease&& other) noexcept { *this = std::move(other); }

MemoryLease& MemoryLease::operator=(MemoryLease&& other) noexcept {
  if (this != &other) {
    release();
    ledger_ = std::exchange(other.ledger_, nullptr);
    client_ = other.client_;
    bytes_ = other.bytes_;
    waits_ = other.waits_;
  }
  return *this;
}

bool MemoryLease::resize(std::uint64_t bytes) { return ledger_ != nullptr && ledger_->resize(*this, bytes); }

void MemoryLease::release() {
  if (ledger_ != nullptr) ledger_->release(*this);
  ledger_ = nullptr;
}

std::optional<MemoryLease> MemoryLedger::lease(const std::string& client, std::uint64_t bytes) {
  const Time now = now_();
  const MutexLock lock(mutex_);
  forget_clients(now);
  const auto entry = clients_.try_emplace(client).first;
  if (!has_room_for(entry->second, bytes)) {
    entry->second.refused_until = now + kRefusedFor;
    return std::nullopt;
  }
  entry->second.bytes += bytes;
  ++entry->second.leases;
  leased_ += bytes;
  waiting_ += bytes;
  MemoryLease lease;
  lease.ledger_ = this;
  lease.client_ = &entry->first;
  lease.bytes_ = bytes;
  return lease;
}

std::uint64_t MemoryLedger::leased() const {
  const MutexLock lock(mutex_);
  return leased_;
}

bool MemoryLedger::has_room_for(const Client& client, std::uint64_t bytes) const {
  if (bytes > budget_ - leased_) return false;
  if (waiting_ > 0 && bytes > budget_ / 2 - std::min(budget_ / 2, waiting_)) return false;
  const bool others_were_refused = std::ranges::any_of(clients_, [&client](const Clients::value_type& entry) {
    return &entry.second != &client && entry.second.refused_until > Time();
  });
  return !others_were_refused || client.bytes + bytes <= budget_ / clients_.size();
}

void MemoryLedger::forget_clients(Time now) {
  for (auto& [name, client] : clients_) {
    if (client.refused_until <= now) client.refused_until = Time();
  }
  std::erase_if(clients_, [](const Clients::value_type& entry) {
    return entry.second.leases == 0 && entry.second.refused_until == Time();
  });
}

bool MemoryLedger::resize(MemoryLease& lease, std::uint64_t bytes) {
  const MutexLock lock(mutex_);
  if (bytes > lease.bytes_ && bytes - lease.bytes_ > budget_ - leased_) return false;
  if (std::exchange(lease.waits_, false)) waiting_ -= lease.bytes_;
  leased_ += bytes - lease.bytes_;
  clients_.find(*lease.client_)->second.bytes += bytes - lease.bytes_;
  lease.bytes_ = bytes;
  return true;
}

void MemoryLedger::release(const MemoryLease& lease) {
  const MutexLock lock(mutex_);
  leased_ -= lease.bytes_;
  if (lease.waits_) waiting_ -= lease.bytes_;
  const auto client = clients_.find(*lease.client_);
  client->second.bytes -= lease.bytes_;
  if (--client->second.leases == 0 && client->second.refused_until == Time()) clients_.erase(client);
}

std::uint64_t available_memory() {
  const auto pages = static_cast<std::uint64_t>(std::max(0L, sysconf(_SC_PHYS_PAGES)));
  const auto page_bytes = static_cast<std::uint64_t>(std::max(0L, sysconf(_SC_PAGESIZE)));
  return std::min(cgroup_limit(), pages * page_bytes);
}

}  // namespace segserve::server
