// SPDX-License-Identifier: Apache-2.0
#include "server/rpc/unary_calls.hpp"

#include <utility>

#include "server/rpc/segment_call.hpp"

namespace segserve::server {

void UnaryCalls::add(std::shared_ptr<SegmentCall> call) {
  const MutexLock lock(mutex_);
  calls_.insert(std::move(call));
}

void UnaryCalls::remove(const std::shared_ptr<SegmentCall>& call) {
  const MutexLock lock(mutex_);
  calls_.erase(call);
}

std::size_t UnaryCalls::count() const {
  const MutexLock lock(mutex_);
  return calls_.size();
}

void UnaryCalls::on_tick(std::chrono::steady_clock::time_point now) {
  for (const auto& call : snapshot()) call->on_tick(now);
}

void UnaryCalls::abort_all() {
  for (const auto& call : snapshot()) call->abort();
}

std::vector<std::shared_ptr<SegmentCall>> UnaryCalls::snapshot() const {
  const MutexLock lock(mutex_);
  return {calls_.begin(), calls_.end()};
}

}  // namespace segserve::server
