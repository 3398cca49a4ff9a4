// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <string_view>

#include "absl/status/statusor.h"

// Two ends that have the same secret prove it to each other without sending it: one sends a challenge, which it uses
// once, and the other an HMAC of it.
namespace segserve::credentials {

/// Reads a secret of 16 to 1024 bytes from a file; white space around it does not count. NOT_FOUND if the file cannot
/// be read or is no regular one, INVALID_ARGUMENT if the secret is too short or too long.
absl::StatusOr<std::string> read_shared_secret(const std::string& path);

/// The HMAC-SHA256 (RFC 2104) of a message by a secret, as 64 hexadecimal digits.
std::string proof_of(std::string_view secret, std::string_view message);

/// Whether a text is that proof, in a time that does not depend on where it differs.
bool is_proof_of(std::string_view proof, std::string_view secret, std::string_view message);

}  // namespace segserve::credentials
