// SPDX-License-Identifier: Apache-2.0
#include "credentials/public_key.hpp"

#include <openssl/bn.h>
#include <openssl/core_names.h>
#include <openssl/ecdsa.h>
#include <openssl/err.h>
#include <openssl/evp.h>
#include <openssl/param_build.h>

#include <algorithm>
#include <array>
#include <string>
#include <utility>
#include <vector>

#include "core/base/status_macros.hpp"

namespace segserve::credentials {
namespace {

template <auto Free>
struct Deleter {
  template <typename Type>
  void operator()(Type* object) const {
    Free(object);
  }
};
using BigNumber = std::unique_ptr<BIGNUM, Deleter<BN_free>>;
using KeyContext = std::unique_ptr<EVP_PKEY_CTX, Deleter<EVP_PKEY_CTX_free>>;
using DigestContext = std::unique_ptr<EVP_MD_CTX, Deleter<EVP_MD_CTX_free>>;
using ParamBuilder = std::unique_ptr<OSSL_PARAM_BLD, Deleter<OSSL_PARAM_BLD_free>>;
using Params = std::unique_ptr<OSSL_PARAM, Deleter<OSSL_PARAM_free>>;
using EcdsaSignature = std::unique_ptr<ECDSA_SIG, Deleter<ECDSA_SIG_free>>;
using SharedKey = std::shared_ptr<EVP_PKEY>;

constexpr std::size_t kP256Bytes = 32, kEd25519Bytes = 32, kEd25519SignatureBytes = 64;

constexpr std::array<std::pair<std::string_view, SignatureAlgorithm>, 3> kNames{
    {{"RS256", SignatureAlgorithm::kRs256},
     {"ES256", SignatureAlgorithm::kEs256},
     {"EdDSA", SignatureAlgorithm::kEdDsa}}};

const unsigned char* bytes_of(std::string_view text) { return reinterpret_cast<const unsigned char*>(text.data()); }

BigNumber number_of(std::string_view big_endian) {
  return BigNumber(BN_bin2bn(bytes_of(big_endian), static_cast<int>(big_endian.size()), nullptr));
}

/// Null if the parameters make no key of this type. OpenSSL checks that a point is on its curve.
SharedKey make_key(const char* type, OSSL_PARAM_BLD* builder) {
  const Params params(OSSL_PARAM_BLD_to_param(builder));
  const KeyContext context(EVP_PKEY_CTX_new_from_name(nullptr, type, nullptr));
  EVP_PKEY* key = nullptr;
  const bool made = params && context && EVP_PKEY_fromdata_init(context.get()) == 1 &&
                    EVP_PKEY_fromdata(context.get(), &key, EVP_PKEY_PUBLIC_KEY, params.get()) == 1;
  ERR_clear_error();  // which would pile up in the thread's queue
  return made ? SharedKey(key, EVP_PKEY_free) : nullptr;
}

/// The signature as OpenSSL wants it; empty if that is impossible.
std::vector<unsigned char> to_der(std::string_view signature) {
  if (signature.size() != 2 * kP256Bytes) return {};
  const EcdsaSignature pair(ECDSA_SIG_new());
  BigNumber r = number_of(signature.substr(0, kP256Bytes)), s = number_of(signature.substr(kP256Bytes));
  if (!pair || !r || !s || ECDSA_SIG_set0(pair.get(), r.get(), s.get()) != 1) return {};
  std::ignore = r.release();  // the pair owns them now
  std::ignore = s.release();
  std::vector<unsigned char> der(static_cast<std::size_t>(std::max(0, i2d_ECDSA_SIG(pair.get(), nullptr))));
  unsigned char* end = der.data();
  if (der.empty() || i2d_ECDSA_SIG(pair.get(), &end) < 0) return {};
  return der;
}

}  // namespace

std::string_view name(SignatureAlgorithm algorithm) { return kNames[static_cast<std::size_t>(algorithm)].first; }

std::optional<SignatureAlgorithm> algorithm_from_name(std::string_view name) {
  const auto* found = std::ranges::find(kNames, name, [](const auto& entry) { return entry.first; });
  return found == kNames.end() ? std::nullopt : std::optional(found->second);
}

absl::StatusOr<PublicKey> PublicKey::rsa(std::string_view modulus, std::string_view exponent) {
  constexpr int kLeastBits = 2048, kMostBits = 8192, kMostExponentBits = 32;
  constexpr std::size_t kMostBytes = 2048;  // before the numbers are made
  if (modulus.size() > kMostBytes || exponent.size() > kMostBytes) {
    return absl::InvalidArgumentError("the RSA key is too large");
  }
  const BigNumber n = number_of(modulus), e = number_of(exponent);
  if (!n || !e || BN_num_bits(n.get()) < kLeastBits || BN_num_bits(n.get()) > kMostBits) {
    return absl::InvalidArgumentError("an RSA key must have 2048 to 8192 bits");
  }
  if (!BN_is_odd(e.get()) || BN_is_one(e.get()) || BN_num_bits(e.get()) > kMostExponentBits) {
    return absl::InvalidArgumentError("the exponent of an RSA key must be an odd number from 3 to 2^32");
  }
  const ParamBuilder builder(OSSL_PARAM_BLD_new());
  const bool built = builder && OSSL_PARAM_BLD_push_BN(builder.get(), OSSL_PKEY_PARAM_RSA_N, n.get()) == 1 &&
                     OSSL_PARAM_BLD_push_BN(builder.get(), OSSL_PKEY_PARAM_RSA_E, e.get()) == 1;
  SharedKey key = built ? make_key("RSA", builder.get()) : nullptr;
  if (!key) return absl::InvalidArgumentError("the numbers are no RSA key");
  return PublicKey(SignatureAlgorithm::kRs256, std::move(key));
}

absl::StatusOr<PublicKey> PublicKey::p256(std::string_view x, std::string_view y) {
  if (x.size() != kP256Bytes || y.size() != kP256Bytes) {
    return absl::InvalidArgumentError("the coordinates of a P-256 key must have 32 bytes each");
  }
  constexpr char kUncompressed = 4;
  const std::string point = kUncompressed + std::string(x) + std::string(y);
  const ParamBuilder builder(OSSL_PARAM_BLD_new());
  const bool built =
      builder && OSSL_PARAM_BLD_push_utf8_string(builder.get(), OSSL_PKEY_PARAM_GROUP_NAME, "prime256v1", 0) == 1 &&
      OSSL_PARAM_BLD_push_octet_string(builder.get(), OSSL_PKEY_PARAM_PUB_KEY, point.data(), point.size()) == 1;
  SharedKey key = built ? make_key("EC", builder.get()) : nullptr;
  if (!key) return absl::InvalidArgumentError("the coordinates are no point of P-256");
  return PublicKey(SignatureAlgorithm::kEs256, std::move(key));
}

absl::StatusOr<PublicKey> PublicKey::ed25519(std::string_view bytes) {
  if (bytes.size() != kEd25519Bytes) return absl::InvalidArgumentError("an Ed25519 key must have 32 bytes");
  SharedKey key(EVP_PKEY_new_raw_public_key(EVP_PKEY_ED25519, nullptr, bytes_of(bytes), bytes.size()), EVP_PKEY_free);
  if (!key) return absl::InvalidArgumentError("the bytes are no Ed25519 key");
  return PublicKey(SignatureAlgorithm::kEdDsa, std::move(key));
}

bool PublicKey::verifies(std::string_view message, std::string_view signature) const {
  std::vector<unsigned char> bytes(signature.begin(), signature.end());
  if (algorithm_ == SignatureAlgorithm::kEs256) bytes = to_der(signature);
  if (algorithm_ == SignatureAlgorithm::kEdDsa && bytes.size() != kEd25519SignatureBytes) return false;
  if (bytes.empty()) return false;
  const EVP_MD* digest = algorithm_ == SignatureAlgorithm::kEdDsa ? nullptr : EVP_sha256();
  const DigestContext context(EVP_MD_CTX_new());
  // The padding of RSA is PKCS #1 v1.5 unless somebody asks for another one, which is that of RS256.
  const bool verified =
      context && EVP_DigestVerifyInit(context.get(), nullptr, digest, nullptr, key_.get()) == 1 &&
      EVP_DigestVerify(context.get(), bytes.data(), bytes.size(), bytes_of(message), message.size()) == 1;
  ERR_clear_error();
  return verified;
}

bool operator==(const PublicKey& a, const PublicKey& b) {
  return a.key_ == b.key_ || EVP_PKEY_eq(a.key_.get(), b.key_.get()) == 1;
}

}  // namespace segserve::credentials
