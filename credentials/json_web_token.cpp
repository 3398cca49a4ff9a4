// SPDX-License-Identifier: Apache-2.0
#include "credentials/json_web_token.hpp"

#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>

#include "absl/strings/ascii.h"
#include "core/base/status_macros.hpp"
#include "core/base/status_text.hpp"
#include "core/base/strict_json.hpp"
#include "credentials/base64url.hpp"
#include "fmt/format.h"
#include "nlohmann/json.hpp"

namespace segserve::credentials {
namespace {

using Json = nlohmann::json;
using Time = std::chrono::system_clock::time_point;

constexpr std::size_t kMostSubjectBytes = 256;

absl::Status refused(std::string_view why) { return absl::UnauthenticatedError(fmt::format("JWT: {}", why)); }

/// The parts between the dots, of which there are two.
struct Parts {
  std::string_view header, payload, signature, signed_text;
};

Parts split(std::string_view token) {
  const std::size_t first = token.find('.'), second = token.find('.', first + 1);
  return {token.substr(0, first), token.substr(first + 1, second - first - 1), token.substr(second + 1),
          token.substr(0, second)};
}

absl::StatusOr<Json> object_of(std::string_view part, std::string_view name) {
  const std::optional<std::string> text = from_base64url(part);
  auto object = text ? parse_strict_json<Json>(*text) : absl::StatusOr<Json>(Json());
  if (!object.ok() && message_of(object.status()).ends_with(" twice")) {  // RFC 7519, section 4
    return refused(fmt::format("the {}: {}", name, message_of(object.status())));
  }
  if (!object.ok() || !object->is_object()) {
    return refused(fmt::format("the {} is no JSON object in base64url", name));
  }
  return object;
}

std::string text_of(const Json& object, const char* member) {
  const auto found = object.find(member);
  return found != object.end() && found->is_string() ? found->get<std::string>() : "";
}

/// A time in seconds since 1970. nullopt if the member is missing; an error if it is no such time.
absl::StatusOr<std::optional<Time>> time_of(const Json& claims, const char* member) {
  const auto found = claims.find(member);
  if (found == claims.end()) return std::nullopt;
  constexpr double kYear10000 = 253402300800, kLatest = 9'000'000'000;  // the clock of the system ends in 2262
  const double seconds = found->is_number() ? found->get<double>() : -1;
  if (!(seconds >= 0 && seconds < kYear10000)) return refused(fmt::format("'{}' is no time", member));
  return Time(std::chrono::seconds(static_cast<std::int64_t>(std::floor(std::min(seconds, kLatest)))));
}

/// RFC 8725, section 3.11: a token that was made for something else is none for a call.
bool is_type_of_access(const Json& header) {
  if (!header.contains("typ")) return true;
  std::string type = absl::AsciiStrToLower(text_of(header, "typ"));
  constexpr std::string_view kPrefix = "application/";
  if (type.starts_with(kPrefix)) type.erase(0, kPrefix.size());
  return type == "jwt" || type == "at+jwt";
}

absl::StatusOr<JsonWebKey> key_of(const Json& header, const JsonWebKeys& keys) {
  if (header.contains("crit")) return refused("it has critical extensions, of which none is known");
  if (!is_type_of_access(header)) return refused("its 'typ' is not that of a token for access");
  const std::optional<SignatureAlgorithm> algorithm = algorithm_from_name(text_of(header, "alg"));
  if (!algorithm) return refused("its algorithm is not RS256, ES256 or EdDSA");
  const std::string id = text_of(header, "kid");
  if (id.empty()) return refused("it has no 'kid'");
  const auto key = std::ranges::find(keys, id, &JsonWebKey::id);
  if (key == keys.end()) return refused("no key has its 'kid'");
  if (key->key.algorithm() != *algorithm) return refused("its algorithm is not that of its key");
  return *key;
}

bool is_for(const Json& claims, const std::string& audience) {
  const auto found = claims.find("aud");
  if (found == claims.end()) return false;
  if (!found->is_array()) return *found == audience;
  return std::ranges::find(*found, Json(audience)) != found->end();
}

absl::Status check_claims(const Json& claims, const JwtPolicy& policy, Time now) {
  if (text_of(claims, "iss") != policy.issuer) return refused("its issuer is another one");
  if (!is_for(claims, policy.audience)) return refused("its audience is another one");
  ASSIGN_OR_RETURN(const std::optional<Time> not_before, time_of(claims, "nbf"));
  if (not_before && *not_before > now + kJwtLeeway) return refused("it is not valid yet");
  ASSIGN_OR_RETURN(const std::optional<Time> issued, time_of(claims, "iat"));
  if (issued && *issued > now + kJwtLeeway) return refused("it was issued in the future");
  return absl::OkStatus();
}

absl::StatusOr<std::string> subject_of(const Json& claims) {
  std::string subject = text_of(claims, "sub");
  const bool is_name = !subject.empty() && subject.size() <= kMostSubjectBytes &&
                       std::ranges::none_of(subject, [](unsigned char byte) { return absl::ascii_iscntrl(byte); });
  if (!is_name) return refused("its subject is no name");
  return subject;
}

}  // namespace

bool looks_like_jwt(std::string_view token) { return std::ranges::count(token, '.') == 2; }

absl::StatusOr<JwtClaims> verify_jwt(std::string_view token, const JsonWebKeys& keys, const JwtPolicy& policy,
                                     std::chrono::system_clock::time_point now) {
  if (token.size() > kMostJwtBytes) return refused(fmt::format("it has more than {} bytes", kMostJwtBytes));
  if (!looks_like_jwt(token)) return refused("it does not have three parts");
  const Parts parts = split(token);
  ASSIGN_OR_RETURN(const Json header, object_of(parts.header, "header"));
  ASSIGN_OR_RETURN(JsonWebKey key, key_of(header, keys));
  const std::optional<std::string> signature = from_base64url(parts.signature);
  if (!signature || !key.key.verifies(parts.signed_text, *signature)) return refused("its signature is wrong");

  // From here on the issuer has said all that follows.
  ASSIGN_OR_RETURN(const Json claims, object_of(parts.payload, "payload"));
  RETURN_IF_ERROR(check_claims(claims, policy, now));
  ASSIGN_OR_RETURN(std::string subject, subject_of(claims));
  ASSIGN_OR_RETURN(const std::optional<Time> expires, time_of(claims, "exp"));
  if (!expires) return refused("it has no 'exp'");
  return JwtClaims{std::move(subject), *expires + kJwtLeeway, std::move(key)};
}

}  // namespace segserve::credentials
