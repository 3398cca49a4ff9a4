// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string_view>

#include "absl/status/statusor.h"

// OpenSSL's type for keys of any kind.
struct evp_pkey_st;

namespace segserve::credentials {

/// The signatures of RFC 7518 and RFC 8037 that are accepted: those that need no secret on this side.
enum class SignatureAlgorithm : std::uint8_t { kRs256, kEs256, kEdDsa };

/// "RS256", "ES256" or "EdDSA".
std::string_view name(SignatureAlgorithm algorithm);
/// nullopt for all others, among them "none" and "HS256".
std::optional<SignatureAlgorithm> algorithm_from_name(std::string_view name);

/// A key that checks signatures of one algorithm. Copies share it; thread-safe.
class PublicKey {
 public:
  /// `modulus` and `exponent` are big-endian. INVALID_ARGUMENT unless the modulus has 2048 to 8192 bits and the
  /// exponent is an odd number from 3 to 2^32: others are weak, or take long to check.
  static absl::StatusOr<PublicKey> rsa(std::string_view modulus, std::string_view exponent);
  /// The coordinates of a point of P-256, 32 bytes each. INVALID_ARGUMENT if it is none.
  static absl::StatusOr<PublicKey> p256(std::string_view x, std::string_view y);
  /// 32 bytes of an Ed25519 key.
  static absl::StatusOr<PublicKey> ed25519(std::string_view bytes);

  SignatureAlgorithm algorithm() const { return algorithm_; }

  /// Whether the holder of the private key has signed the message. The signature is as in a JSON Web Signature: for
  /// ES256 two numbers of 32 bytes, and not DER.
  bool verifies(std::string_view message, std::string_view signature) const;

  friend bool operator==(const PublicKey& a, const PublicKey& b);

 private:
  PublicKey(SignatureAlgorithm algorithm, std::shared_ptr<evp_pkey_st> key)
      : algorithm_(algorithm), key_(std::move(key)) {}

  SignatureAlgorithm algorithm_;
  std::shared_ptr<evp_pkey_st> key_;
};

}  // namespace segserve::credentials
