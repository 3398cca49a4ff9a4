// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>
#include <cstdint>
#include <string_view>

#include "absl/status/status.h"

// The server's answers to callers who have not proved who they are, and to frames beyond the limits of their subject.
// The proofs' answers do not tell what was wrong with a proof, because that would help who tries to forge one.
namespace segserve::server {

/// UNAUTHENTICATED, TOKEN_MISSING: the call has no token.
absl::Status token_missing();
/// UNAUTHENTICATED, TOKEN_INVALID: the token is not, or no longer, one that the server accepts.
absl::Status token_invalid();
/// UNAUTHENTICATED, TOKEN_EXPIRED: the token was good until its time was over.
absl::Status token_expired();

/// RESOURCE_EXHAUSTED, QUOTA_EXCEEDED, with a google.rpc.QuotaFailure: the frame may come again after `wait`. `limit`
/// is the name of the limit of the subject, and `allowed` its value.
absl::Status quota_exceeded(std::string_view subject, std::string_view limit, double allowed,
                            std::chrono::milliseconds wait);

/// RESOURCE_EXHAUSTED, LIMIT_EXCEEDED: the frame alone is beyond the limit, so that it would never be taken.
absl::Status frame_beyond_quota(std::string_view subject, std::string_view limit, std::uint64_t allowed,
                                std::uint64_t actual);

}  // namespace segserve::server
