// SPDX-License-Identifier: Apache-2.0
#include "server/memory/memory_ledger.hpp"

#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <limits>
#include <string>

namespace segserve::server {
namespace {

// How long a client that was refused counts as one that waits. Refusals tell it to come again earlier than that.
constexpr std::chrono::seconds kRefusalCountsFor{5};
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
    owner_ = std::move(other.owner_);
    bytes_ = other.bytes_;
    kind_ = other.kind_;
  }
  return *this;
}

bool MemoryLease::resize(std::uint64_t bytes, LeaseKind kind) {
  return ledger_ != nullptr && ledger_->resize(*this, bytes, kind);
}

void MemoryLease::release() {
  if (ledger_ != nullptr) ledger_->release(*this);
  ledger_ = nullptr;
}

std::optional<MemoryLease> MemoryLedger::lease(const MemoryOwner& owner, std::uint64_t bytes) {
  const Time now = now_();
  MemoryLease lease;
  lease.owner_ = owner;
  lease.bytes_ = bytes;
  const MutexLock lock(mutex_);
  forget_refusals(now);
  addresses_[owner.address].streams.try_emplace(owner.stream);
  if (!has_room_for(owner, bytes)) {
    note_refusal(owner, now);
    return std::nullopt;
  }
  for (Holding* holding : holdings_of(owner)) ++holding->leases;
  change(owner, 0, bytes);
  of(LeaseKind::kWaiting) += bytes;
  lease.ledger_ = this;
  return lease;
}

bool MemoryLedger::is_short() const {
  const Time now = now_();
  const MutexLock lock(mutex_);
  return is_short_at(now);
}

bool MemoryLedger::is_short_at(Time now) const {
  return last_refusal_ != Time() && now < last_refusal_ + kRefusalCountsFor;
}

std::uint64_t MemoryLedger::leased() const {
  const MutexLock lock(mutex_);
  return leased_;
}

MemoryUse MemoryLedger::use() const {
  const Time now = now_();
  const MutexLock lock(mutex_);
  return {.budget = budget_, .leased = by_kind_, .refusals = refusals_, .is_short = is_short_at(now)};
}

bool MemoryLedger::has_room_for(const MemoryOwner& owner, std::uint64_t bytes) const {
  if (bytes > budget_ - leased_) return false;
  const std::uint64_t waiting = by_kind_[static_cast<std::size_t>(LeaseKind::kWaiting)];
  if (waiting > 0 && bytes > budget_ / 2 - std::min(budget_ / 2, waiting)) return false;
  const auto others_were_refused = [](const auto& holdings, const std::string& self, const auto& holding_of) {
    return std::ranges::any_of(holdings, [&](const auto& entry) {
      return entry.first != self && holding_of(entry.second).refused_until > Time();
    });
  };
  const Address& address = addresses_.find(owner.address)->second;
  std::uint64_t limit = budget_;
  if (others_were_refused(addresses_, owner.address, [](const Address& other) { return other.total; })) {
    limit /= addresses_.size();
    if (address.total.bytes > 0 && address.total.bytes + bytes > limit) return false;
  }
  // A client that holds nothing gets what is free, even if it is more than a share: else a crowd could refuse each
  // other for ever.
  const Holding& stream = address.streams.find(owner.stream)->second;
  return stream.bytes == 0 ||
         !others_were_refused(address.streams, owner.stream, [](const Holding& other) { return other; }) ||
         stream.bytes + bytes <= limit / address.streams.size();
}

void MemoryLedger::forget_refusals(Time now) {
  const auto forget = [now](Holding& holding) {
    if (holding.refused_until <= now) holding.refused_until = Time();
    return holding.leases == 0 && holding.refused_until == Time();
  };
  for (auto address = addresses_.begin(); address != addresses_.end();) {
    auto& streams = address->second.streams;
    for (auto stream = streams.begin(); stream != streams.end();) {
      stream = forget(stream->second) ? streams.erase(stream) : std::next(stream);
    }
    address = forget(address->second.total) ? addresses_.erase(address) : std::next(address);
  }
}

std::array<MemoryLedger::Holding*, 2> MemoryLedger::holdings_of(const MemoryOwner& owner) {
  Address& address = addresses_.find(owner.address)->second;
  return {&address.total, &address.streams.find(owner.stream)->second};
}

void MemoryLedger::change(const MemoryOwner& owner, std::uint64_t before, std::uint64_t after) {
  for (Holding* holding : holdings_of(owner)) holding->bytes = holding->bytes - before + after;
  leased_ = leased_ - before + after;
}

void MemoryLedger::note_refusal(const MemoryOwner& owner, Time now) {
  for (Holding* holding : holdings_of(owner)) holding->refused_until = now + kRefusalCountsFor;
  last_refusal_ = now;
  ++refusals_;
}

bool MemoryLedger::resize(MemoryLease& lease, std::uint64_t bytes, LeaseKind kind) {
  const Time now = now_();
  const MutexLock lock(mutex_);
  if (bytes > lease.bytes_ && bytes - lease.bytes_ > budget_ - leased_) {
    note_refusal(lease.owner_, now);
    return false;
  }
  of(lease.kind_) -= lease.bytes_;
  of(kind) += bytes;
  lease.kind_ = kind;
  change(lease.owner_, lease.bytes_, bytes);
  lease.bytes_ = bytes;
  return true;
}

void MemoryLedger::release(const MemoryLease& lease) {
  const MutexLock lock(mutex_);
  of(lease.kind_) -= lease.bytes_;
  change(lease.owner_, lease.bytes_, 0);
  for (Holding* holding : holdings_of(lease.owner_)) --holding->leases;
}

std::uint64_t available_memory() {
  const auto pages = static_cast<std::uint64_t>(std::max(0L, sysconf(_SC_PHYS_PAGES)));
  const auto page_bytes = static_cast<std::uint64_t>(std::max(0L, sysconf(_SC_PAGESIZE)));
  return std::min(cgroup_limit(), pages * page_bytes);
}

}  // namespace segserve::server
