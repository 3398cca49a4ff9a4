// SPDX-License-Identifier: Apache-2.0
#include "server/metrics/refusal_cause.hpp"

#include <array>
#include <string_view>

namespace segserve::server {
namespace {

using wire::ErrorReason;

constexpr const char* kEviction = "eviction";
constexpr std::array kCauses{"queue_frames", "queue_bytes", "queue_points", "memory",
                             kEviction,      "draining",    "token",        "quota"};

/// A status with this reason and, unless it is empty, this limit has this cause.
struct Rule {
  ErrorReason reason;
  std::string_view limit;
  const char* cause;
};
constexpr std::array kRules{
    Rule{ErrorReason::kQueueFull, "max_queue", "queue_frames"},
    Rule{ErrorReason::kQueueFull, "max_queue_bytes", "queue_bytes"},
    Rule{ErrorReason::kQueueFull, "max_queue_points", "queue_points"},
    Rule{ErrorReason::kQueueFull, "memory_bytes", "memory"},
    Rule{ErrorReason::kDraining, "", "draining"},
    Rule{ErrorReason::kTokenMissing, "", "token"},
    Rule{ErrorReason::kTokenInvalid, "", "token"},
    Rule{ErrorReason::kTokenExpired, "", "token"},
    Rule{ErrorReason::kQuotaExceeded, "", "quota"},
};

}  // namespace

std::span<const char* const> refusal_causes() { return kCauses; }

const char* refusal_cause(const StatusFacts& status, bool is_evicted) {
  if (is_evicted) return kEviction;
  for (const Rule& rule : kRules) {
    if (rule.reason == status.reason && (rule.limit.empty() || rule.limit == status.limit)) return rule.cause;
  }
  return nullptr;
}

}  // namespace segserve::server
