// SPDX-License-Identifier: Apache-2.0
#include "credentials/json_web_key.hpp"

#include <algorithm>
#include <optional>

#include "absl/strings/escaping.h"
#include "core/base/status_macros.hpp"
#include "core/base/status_text.hpp"
#include "core/base/strict_json.hpp"
#include "credentials/base64url.hpp"
#include "fmt/format.h"
#include "nlohmann/json.hpp"

namespace segserve::credentials {
namespace {

using Json = nlohmann::json;

constexpr std::size_t kMostKeys = 200, kMostIdBytes = 256;

/// The text of a member; empty if there is none, or if it is no text.
std::string text_of(const Json& object, const char* member) {
  const auto found = object.find(member);
  return found != object.end() && found->is_string() ? found->get<std::string>() : "";
}

absl::StatusOr<std::string> bytes_of(const Json& key, const char* member) {
  std::optional<std::string> bytes = from_base64url(text_of(key, member));
  if (!bytes || bytes->empty()) return absl::InvalidArgumentError(fmt::format("'{}' is no base64url text", member));
  return *std::move(bytes);
}

/// The algorithm that the type of a key implies; nullopt for types that are not accepted.
std::optional<SignatureAlgorithm> algorithm_of(const Json& key) {
  const std::string type = text_of(key, "kty"), curve = text_of(key, "crv");
  if (type == "RSA") return SignatureAlgorithm::kRs256;
  if (type == "EC" && curve == "P-256") return SignatureAlgorithm::kEs256;
  if (type == "OKP" && curve == "Ed25519") return SignatureAlgorithm::kEdDsa;
  return std::nullopt;
}

/// Whether the key is there to check signatures that are accepted.
bool is_usable(const Json& key) {
  const std::optional<SignatureAlgorithm> algorithm = algorithm_of(key);
  if (!algorithm || text_of(key, "kid").empty()) return false;
  if (key.contains("use") && text_of(key, "use") != "sig") return false;
  if (key.contains("alg") && text_of(key, "alg") != name(*algorithm)) return false;
  const auto operations = key.find("key_ops");
  return operations == key.end() || std::ranges::find(*operations, Json("verify")) != operations->end();
}

absl::StatusOr<PublicKey> public_key(const Json& key) {
  if (key.contains("d")) return absl::InvalidArgumentError("the key is a private one, which no server must have");
  switch (*algorithm_of(key)) {
    case SignatureAlgorithm::kRs256: {
      ASSIGN_OR_RETURN(const std::string modulus, bytes_of(key, "n"));
      ASSIGN_OR_RETURN(const std::string exponent, bytes_of(key, "e"));
      return PublicKey::rsa(modulus, exponent);
    }
    case SignatureAlgorithm::kEs256: {
      ASSIGN_OR_RETURN(const std::string x, bytes_of(key, "x"));
      ASSIGN_OR_RETURN(const std::string y, bytes_of(key, "y"));
      return PublicKey::p256(x, y);
    }
    case SignatureAlgorithm::kEdDsa: {
      ASSIGN_OR_RETURN(const std::string x, bytes_of(key, "x"));
      return PublicKey::ed25519(x);
    }
  }
  return absl::InternalError("an unknown algorithm");
}

absl::StatusOr<JsonWebKey> read_key(const Json& key, const JsonWebKeys& others) {
  const std::string id = text_of(key, "kid");
  if (id.size() > kMostIdBytes) {
    return absl::InvalidArgumentError(fmt::format("'kid' has more than {} bytes", kMostIdBytes));
  }
  if (std::ranges::find(others, id, &JsonWebKey::id) != others.end()) {
    return absl::InvalidArgumentError("another key has the same 'kid'");
  }
  ASSIGN_OR_RETURN(PublicKey read, public_key(key));
  return JsonWebKey{id, std::move(read)};
}

}  // namespace

absl::StatusOr<JsonWebKeys> parse_json_web_keys(std::string_view text, std::string_view name) {
  const auto parsed = parse_strict_json<Json>(text);
  if (!parsed.ok()) {
    return absl::InvalidArgumentError(fmt::format("{} is no JSON Web Key Set: {}", name, message_of(parsed.status())));
  }
  const Json& root = *parsed;
  const auto set = root.is_object() ? root.find("keys") : root.end();
  if (!root.is_object() || set == root.end() || !set->is_array()) {
    return absl::InvalidArgumentError(fmt::format("{} is no JSON Web Key Set: an object with an array 'keys'", name));
  }
  if (set->size() > kMostKeys) {
    return absl::InvalidArgumentError(fmt::format("{} has more than {} keys", name, kMostKeys));
  }
  JsonWebKeys keys;
  std::vector<std::string> faults;
  for (std::size_t i = 0; i < set->size(); ++i) {
    const Json& key = (*set)[i];
    if (!key.is_object() || !is_usable(key)) continue;
    auto read = read_key(key, keys);
    if (read.ok()) {
      keys.push_back(*std::move(read));
    } else {
      faults.push_back(fmt::format("{}: key {} ('{}'): {}", name, i + 1,
                                   absl::CHexEscape(text_of(key, "kid").substr(0, 64)), message_of(read.status())));
    }
  }
  if (!faults.empty()) return absl::InvalidArgumentError(fmt::format("{}", fmt::join(faults, "; ")));
  if (keys.empty()) {
    return absl::InvalidArgumentError(
        fmt::format("{} has no key with a 'kid' that checks signatures of RS256, ES256 or EdDSA", name));
  }
  return keys;
}

}  // namespace segserve::credentials
