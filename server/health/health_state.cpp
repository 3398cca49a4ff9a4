// SPDX-License-Identifier: Apache-2.0
#include "server/health/health_state.hpp"

#include <algorithm>
#include <cstddef>

#include "segserve/v1/segmentation_service.grpc.pb.h"

namespace segserve::server {
namespace {

using grpc::health::v1::HealthCheckResponse;

// Each takes some kilobytes. An honest load balancer has one for each of its connections.
constexpr std::size_t kMostObservers = 1000;
// The most observers of one client, so that it cannot have all of them.
constexpr std::ptrdiff_t kMostOfAClient = 100;

}  // namespace

HealthState::Status HealthState::status_of(std::string_view service) const {
  const MutexLock lock(mutex_);
  bool serves = false;
  if (service == "liveness") {
    serves = alive_;
  } else if (service.empty() || service == "readiness" || service == v1::SegmentationService::service_full_name()) {
    serves = alive_ && ready_;
  } else {
    return HealthCheckResponse::SERVICE_UNKNOWN;
  }
  return serves ? HealthCheckResponse::SERVING : HealthCheckResponse::NOT_SERVING;
}

void HealthState::set_ready(bool ready) {
  {
    const MutexLock lock(mutex_);
    ready_ = ready;
  }
  for (const auto& [observer, client] : observers()) observer->on_change();
}

void HealthState::set_alive(bool alive) {
  {
    const MutexLock lock(mutex_);
    alive_ = alive;
  }
  for (const auto& [observer, client] : observers()) observer->on_change();
}

void HealthState::close() {
  {
    const MutexLock lock(mutex_);
    closed_ = true;
  }
  for (const auto& [observer, client] : observers()) observer->on_close();
}

absl::Status HealthState::add(const std::shared_ptr<HealthObserver>& observer, const std::string& client) {
  const MutexLock lock(mutex_);
  if (closed_) return absl::UnavailableError("the server stops");
  if (observers_.size() >= kMostObservers) {
    return absl::ResourceExhaustedError("too many calls watch the health of this server already");
  }
  const auto of_client =
      std::ranges::count_if(observers_, [&client](const auto& entry) { return entry.second == client; });
  if (of_client >= kMostOfAClient) {
    return absl::ResourceExhaustedError("too many calls of this client watch the health of this server already");
  }
  observers_.emplace(observer, client);
  return absl::OkStatus();
}

void HealthState::remove(const std::shared_ptr<HealthObserver>& observer) {
  const MutexLock lock(mutex_);
  observers_.erase(observer);
}

HealthState::Observers HealthState::observers() const {
  const MutexLock lock(mutex_);
  return observers_;
}

}  // namespace segserve::server
