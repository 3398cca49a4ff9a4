// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>
#include <cstddef>
#include <string>
#include <string_view>

#include "absl/status/statusor.h"
#include "credentials/json_web_key.hpp"

namespace segserve::credentials {

constexpr std::size_t kMostJwtBytes = std::size_t{8} << 10U;
/// The most by which the clocks of issuer and server may differ.
constexpr std::chrono::seconds kJwtLeeway{30};

/// Which tokens of an issuer this server accepts.
struct JwtPolicy {
  std::string issuer;    ///< `iss` is exactly this
  std::string audience;  ///< `aud` is this, or has it
};

/// The claims of a token that its issuer has signed for this server.
struct JwtClaims {
  std::string subject;                              ///< `sub`, 1 to 256 bytes without control characters
  std::chrono::system_clock::time_point not_after;  ///< `exp` and the leeway; it may be over
  JsonWebKey key;                                   ///< that checked the signature
};

/// Whether a token is a JSON Web Token by its looks: three parts with dots between them.
bool looks_like_jwt(std::string_view token);

/// Checks a signed JSON Web Token (RFC 7519, RFC 8725). The key is that of `kid`, which is required, and the algorithm
/// must be that of the key, whatever the token says. UNAUTHENTICATED says what is wrong in words for the server's log;
/// they hold no part of the token. That `exp` is over is no error here, because it becomes so while a stream is open:
/// compare `not_after` with the time.
absl::StatusOr<JwtClaims> verify_jwt(std::string_view token, const JsonWebKeys& keys, const JwtPolicy& policy,
                                     std::chrono::system_clock::time_point now);

}  // namespace segserve::credentials
