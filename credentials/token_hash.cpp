// SPDX-License-Identifier: Apache-2.0
#include "credentials/token_hash.hpp"

#include <openssl/crypto.h>
#include <openssl/sha.h>

#include <algorithm>

#include "absl/strings/ascii.h"
#include "absl/strings/escaping.h"

namespace segserve::credentials {

TokenHash hash_of(std::string_view token) {
  TokenHash hash;
  SHA256(reinterpret_cast<const unsigned char*>(token.data()), token.size(), hash.data());
  return hash;
}

bool equal_in_constant_time(const TokenHash& a, const TokenHash& b) {
  return CRYPTO_memcmp(a.data(), b.data(), a.size()) == 0;
}

std::string to_hex(const TokenHash& hash) {
  return absl::BytesToHexString({reinterpret_cast<const char*>(hash.data()), hash.size()});
}

std::optional<TokenHash> hash_from_hex(std::string_view text) {
  TokenHash hash;
  if (text.size() != 2 * hash.size() || !std::ranges::all_of(text, absl::ascii_isxdigit)) return std::nullopt;
  std::ranges::copy(absl::HexStringToBytes({text.data(), text.size()}), hash.begin());
  return hash;
}

}  // namespace segserve::credentials
