// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <string>
#include <string_view>
#include <vector>

#include "absl/status/statusor.h"
#include "credentials/public_key.hpp"

namespace segserve::credentials {

constexpr std::size_t kMostKeyFileBytes = std::size_t{1} << 20U;

/// A key by which an issuer signs tokens.
struct JsonWebKey {
  std::string id;  ///< `kid`, not empty
  PublicKey key;

  friend bool operator==(const JsonWebKey&, const JsonWebKey&) = default;
};

using JsonWebKeys = std::vector<JsonWebKey>;

/// The keys of a JSON Web Key Set (RFC 7517) that check signatures of RS256, ES256 or EdDSA. Others, such as keys for
/// encryption, of other algorithms, or without `kid`, are left out, because sets of identity providers have them.
/// INVALID_ARGUMENT names every fault: the text is no key set, a key is damaged or weak, has a secret part, or has the
/// `kid` of another one; or no key is left. `name` stands for the file in messages.
absl::StatusOr<JsonWebKeys> parse_json_web_keys(std::string_view text, std::string_view name);

}  // namespace segserve::credentials
