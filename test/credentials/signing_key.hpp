// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <openssl/bn.h>
#include <openssl/core_names.h>
#include <openssl/ecdsa.h>
#include <openssl/evp.h>

#include <chrono>
#include <memory>
#include <string>
#include <string_view>

#include "credentials/base64url.hpp"
#include "nlohmann/json.hpp"

namespace segserve::credentials {

/// An issuer's key, which signs tokens as an identity provider does.
class SigningKey {
 public:
  /// `algorithm` is RS256, ES256 or EdDSA.
  explicit SigningKey(std::string algorithm, std::string id = "key-1", std::size_t rsa_bits = 2048)
      : algorithm_(std::move(algorithm)), id_(std::move(id)), key_(nullptr, EVP_PKEY_free) {
    if (algorithm_ == "RS256") key_.reset(EVP_PKEY_Q_keygen(nullptr, nullptr, "RSA", rsa_bits));
    if (algorithm_ == "ES256") key_.reset(EVP_PKEY_Q_keygen(nullptr, nullptr, "EC", "P-256"));
    if (algorithm_ == "EdDSA") key_.reset(EVP_PKEY_Q_keygen(nullptr, nullptr, "ED25519"));
  }

  /// The public half, as a JSON Web Key.
  nlohmann::json public_half() const {
    nlohmann::json key = {{"kid", id_}, {"alg", algorithm_}, {"use", "sig"}};
    if (algorithm_ == "RS256") {
      key.update({{"kty", "RSA"}, {"n", number(OSSL_PKEY_PARAM_RSA_N)}, {"e", number(OSSL_PKEY_PARAM_RSA_E)}});
    } else if (algorithm_ == "ES256") {
      unsigned char point[65];
      std::size_t size = 0;
      EVP_PKEY_get_octet_string_param(key_.get(), OSSL_PKEY_PARAM_PUB_KEY, point, sizeof(point), &size);
      const std::string_view bytes(reinterpret_cast<const char*>(point), size);
      key.update({{"kty", "EC"}, {"crv", "P-256"}});
      key.update({{"x", to_base64url(bytes.substr(1, 32))}, {"y", to_base64url(bytes.substr(33, 32))}});
    } else {
      unsigned char bytes[32];
      std::size_t size = sizeof(bytes);
      EVP_PKEY_get_raw_public_key(key_.get(), bytes, &size);
      key.update({{"kty", "OKP"}, {"crv", "Ed25519"}});
      key["x"] = to_base64url({reinterpret_cast<const char*>(bytes), size});
    }
    return key;
  }

  nlohmann::json header() const { return {{"alg", algorithm_}, {"kid", id_}, {"typ", "JWT"}}; }

  std::string token(const nlohmann::json& claims) const { return token(header(), claims.dump()); }
  std::string token(const nlohmann::json& header, std::string_view payload) const {
    const std::string text = to_base64url(header.dump()) + "." + to_base64url(payload);
    return text + "." + to_base64url(sign(text));
  }

  std::string sign(std::string_view text) const {
    const std::unique_ptr<EVP_MD_CTX, decltype(&EVP_MD_CTX_free)> context(EVP_MD_CTX_new(), EVP_MD_CTX_free);
    EVP_DigestSignInit(context.get(), nullptr, algorithm_ == "EdDSA" ? nullptr : EVP_sha256(), nullptr, key_.get());
    std::string signature(1024, '\0');
    std::size_t size = signature.size();
    EVP_DigestSign(context.get(), reinterpret_cast<unsigned char*>(signature.data()), &size,
                   reinterpret_cast<const unsigned char*>(text.data()), text.size());
    signature.resize(size);
    return algorithm_ == "ES256" ? from_der(signature) : signature;
  }

 private:
  std::string number(const char* name) const {
    BIGNUM* value = nullptr;
    EVP_PKEY_get_bn_param(key_.get(), name, &value);
    std::string bytes(static_cast<std::size_t>(BN_num_bytes(value)), '\0');
    BN_bn2bin(value, reinterpret_cast<unsigned char*>(bytes.data()));
    BN_free(value);
    return to_base64url(bytes);
  }

  static std::string from_der(const std::string& der) {
    const auto* begin = reinterpret_cast<const unsigned char*>(der.data());
    ECDSA_SIG* pair = d2i_ECDSA_SIG(nullptr, &begin, static_cast<long>(der.size()));
    unsigned char bytes[64];
    BN_bn2binpad(ECDSA_SIG_get0_r(pair), bytes, 32);
    BN_bn2binpad(ECDSA_SIG_get0_s(pair), bytes + 32, 32);
    ECDSA_SIG_free(pair);
    return {reinterpret_cast<const char*>(bytes), sizeof(bytes)};
  }

  std::string algorithm_, id_;
  std::unique_ptr<EVP_PKEY, decltype(&EVP_PKEY_free)> key_;
};

inline std::int64_t seconds_of(std::chrono::system_clock::time_point time) {
  return std::chrono::duration_cast<std::chrono::seconds>(time.time_since_epoch()).count();
}

/// The key set of an issuer.
inline std::string key_set(const std::vector<nlohmann::json>& keys) { return nlohmann::json{{"keys", keys}}.dump(); }

}  // namespace segserve::credentials
