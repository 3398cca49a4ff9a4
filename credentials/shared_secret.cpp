// SPDX-License-Identifier: Apache-2.0
#include "credentials/shared_secret.hpp"

#include <openssl/evp.h>
#include <openssl/hmac.h>

#include <cstddef>
#include <optional>

#include "absl/strings/ascii.h"
#include "core/base/regular_file.hpp"
#include "core/base/status_macros.hpp"
#include "credentials/token_hash.hpp"
#include "fmt/format.h"

namespace segserve::credentials {
namespace {

TokenHash hmac_of(std::string_view secret, std::string_view message) {
  TokenHash hmac{};
  HMAC(EVP_sha256(), secret.data(), static_cast<int>(secret.size()),
       reinterpret_cast<const unsigned char*>(message.data()), message.size(), hmac.data(), nullptr);
  return hmac;
}

}  // namespace

absl::StatusOr<std::string> read_shared_secret(const std::string& path) {
  constexpr std::size_t kLeastBytes = 16, kMostBytes = 1024, kMostSpace = 64;
  ASSIGN_OR_RETURN(const std::string content, read_regular_file(path, kMostBytes + kMostSpace));
  std::string secret(absl::StripAsciiWhitespace(content));
  if (secret.size() >= kLeastBytes && secret.size() <= kMostBytes) return secret;
  return absl::InvalidArgumentError(fmt::format("{} holds a secret of {} bytes, but it must have {} to {}", path,
                                                secret.size(), kLeastBytes, kMostBytes));
}

std::string proof_of(std::string_view secret, std::string_view message) { return to_hex(hmac_of(secret, message)); }

bool is_proof_of(std::string_view proof, std::string_view secret, std::string_view message) {
  const std::optional<TokenHash> given = hash_from_hex(proof);
  return given && equal_in_constant_time(*given, hmac_of(secret, message));
}

}  // namespace segserve::credentials
