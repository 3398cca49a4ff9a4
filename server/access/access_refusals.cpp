// SPDX-License-Identifier: Apache-2.0
#include "server/access/access_refusals.hpp"

#include <string>

#include "fmt/format.h"
#include "proto/wire/status_message.hpp"

namespace segserve::server {
namespace {

wire::QuotaViolation violation(std::string_view subject, std::string_view limit, std::string_view allowed) {
  return {.subject = fmt::format("subject:{}", subject), .description = fmt::format("{} is {}", limit, allowed)};
}

}  // namespace

absl::Status token_missing() {
  return wire::with_reason(absl::UnauthenticatedError("the server asks for a bearer token, and the call has none"),
                           wire::ErrorReason::kTokenMissing);
}

absl::Status token_invalid() {
  return wire::with_reason(absl::UnauthenticatedError("the server does not accept the token of the call"),
                           wire::ErrorReason::kTokenInvalid);
}

absl::Status token_expired() {
  return wire::with_reason(absl::UnauthenticatedError("the token of the call has expired"),
                           wire::ErrorReason::kTokenExpired);
}

absl::Status quota_exceeded(std::string_view subject, std::string_view limit, double allowed,
                            std::chrono::milliseconds wait) {
  const std::string value = fmt::format("{}", allowed);
  return wire::with_details(
      absl::ResourceExhaustedError(fmt::format("the quota is used up: {} is {}; try again later", limit, value)),
      {.reason = wire::ErrorReason::kQuotaExceeded,
       .metadata = {{"limit", std::string(limit)}, {"allowed", value}},
       .quotas = {violation(subject, limit, value)},
       .retry_delay = wait});
}

absl::Status frame_beyond_quota(std::string_view subject, std::string_view limit, std::uint64_t allowed,
                                std::uint64_t actual) {
  const std::string value = fmt::format("{}", allowed);
  return wire::with_details(
      absl::ResourceExhaustedError(fmt::format("the frame has {} bytes, more than {} = {}", actual, limit, value)),
      {.reason = wire::ErrorReason::kLimitExceeded,
       .metadata = {{"limit", std::string(limit)}, {"allowed", value}, {"actual", fmt::format("{}", actual)}},
       .quotas = {violation(subject, limit, value)}});
}

}  // namespace segserve::server
