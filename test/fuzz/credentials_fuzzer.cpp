// SPDX-License-Identifier: Apache-2.0
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <string>
#include <string_view>

#include "credentials/json_web_key.hpp"
#include "credentials/json_web_token.hpp"
#include "credentials/token_file.hpp"
#include "test/credentials/signing_key.hpp"

namespace segserve::credentials {
namespace {

const SigningKey& issuer() {
  static const SigningKey key("EdDSA");
  return key;
}

const JsonWebKeys& keys() {
  static const JsonWebKeys keys = parse_json_web_keys(key_set({issuer().public_half()}), "keys").value();
  return keys;
}

void verify(std::string_view token, bool is_forged) {
  const std::chrono::system_clock::time_point now{std::chrono::seconds(1'800'000'000)};
  const auto verified = verify_jwt(token, keys(), {"https://idp.example", "segserve"}, now);
  if (verified.ok() && (is_forged || verified->subject.empty() || verified->subject.size() > 256)) std::abort();
}

}  // namespace
}  // namespace segserve::credentials

// Files of tokens, sets of keys, tokens as they come, and tokens whose header or payload is what a signer was made to
// sign. The first byte says which.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace segserve::credentials;
  if (size == 0) return 0;
  const std::string_view text(reinterpret_cast<const char*>(data) + 1, size - 1);
  switch (data[0] % 4) {
    case 0:
      if (const auto file = parse_token_file(text, "tokens"); file.ok()) file->find(hash_of("token"));
      break;
    case 1:
      if (const auto read = parse_json_web_keys(text, "keys"); read.ok() && read->empty()) std::abort();
      break;
    case 2:
      verify(text, true);
      break;
    default:
      verify(issuer().token(issuer().header(), text), false);
      break;
  }
  return 0;
}
