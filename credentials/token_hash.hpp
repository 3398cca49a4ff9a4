// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

namespace segserve::credentials {

/// The SHA-256 of a token. Tokens have 256 random bits, so that their hash needs neither salt nor a slow function.
using TokenHash = std::array<std::uint8_t, 32>;

TokenHash hash_of(std::string_view token);

/// Whether two hashes are equal, in a time that does not depend on where they differ.
bool equal_in_constant_time(const TokenHash& a, const TokenHash& b);

/// 64 hexadecimal digits, in lower case.
std::string to_hex(const TokenHash& hash);
/// nullopt unless the text has 64 hexadecimal digits, of any case.
std::optional<TokenHash> hash_from_hex(std::string_view text);

}  // namespace segserve::credentials
