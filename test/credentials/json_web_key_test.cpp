// SPDX-License-Identifier: Apache-2.0
#include "credentials/json_web_key.hpp"

#include <string>

#include "gmock/gmock.h"
#include "test/credentials/signing_key.hpp"

namespace segserve::credentials {
namespace {

using Json = nlohmann::json;
using testing::HasSubstr;

std::string key_faults(const std::string& text) {
  const auto keys = parse_json_web_keys(text, "k.json");
  EXPECT_TRUE(absl::IsInvalidArgument(keys.status())) << text;
  return std::string(keys.status().message());
}

Json key(const char* algorithm = "EdDSA", const char* id = "key-1") { return SigningKey(algorithm, id).public_half(); }

Json changed(Json key, const char* member, const Json& value) {
  key[member] = value;
  return key;
}

TEST(JsonWebKeys, AreReadOfEveryKind) {
  const auto keys = parse_json_web_keys(key_set({key("RS256", "a"), key("ES256", "b"), key("EdDSA", "c")}), "k.json");
  ASSERT_TRUE(keys.ok()) << keys.status();
  ASSERT_EQ(keys->size(), 3U);
  EXPECT_EQ((*keys)[0].key.algorithm(), SignatureAlgorithm::kRs256);
  EXPECT_EQ((*keys)[1].key.algorithm(), SignatureAlgorithm::kEs256);
  EXPECT_EQ((*keys)[2].key.algorithm(), SignatureAlgorithm::kEdDsa);
  EXPECT_EQ((*keys)[2].id, "c");
  EXPECT_FALSE((*keys)[1] == (*keys)[2]);
}

TEST(JsonWebKeys, OfOtherUsesAreLeftOut) {
  Json without_id = key();
  without_id.erase("kid");
  const Json secret = {{"kty", "oct"}, {"kid", "s"}, {"k", "AAAA"}};
  const auto keys = parse_json_web_keys(
      key_set({without_id, secret, changed(key(), "use", "enc"), changed(key(), "alg", "RS256"),
               changed(key(), "key_ops", {"sign"}), changed(key(), "crv", "X25519"), changed(key(), "kty", 3),
               Json("text"), changed(key("EdDSA", "good"), "key_ops", {"verify"})}),
      "k.json");
  ASSERT_TRUE(keys.ok()) << keys.status();
  ASSERT_EQ(keys->size(), 1U);
  EXPECT_EQ(keys->front().id, "good");
}

TEST(JsonWebKeys, TellEveryFault) {
  const std::string faults =
      key_faults(key_set({changed(key("EdDSA", "a"), "x", "=="), changed(key("EdDSA", "b"), "d", "AAAA"),
                          SigningKey("RS256", "c", 1024).public_half(), key("EdDSA", "d"), key("EdDSA", "d"),
                          changed(key("ES256", "e"), "y", "AAAA")}));
  EXPECT_THAT(faults, HasSubstr("k.json: key 1 ('a'): 'x' is no base64url text"));
  EXPECT_THAT(faults, HasSubstr("k.json: key 2 ('b'): the key is a private one"));
  EXPECT_THAT(faults, HasSubstr("k.json: key 3 ('c'): an RSA key must have 2048 to 8192 bits"));
  EXPECT_THAT(faults, HasSubstr("k.json: key 5 ('d'): another key has the same 'kid'"));
  EXPECT_THAT(faults, HasSubstr("k.json: key 6 ('e'): the coordinates of a P-256 key"));
}

TEST(JsonWebKeys, AreInASet) {
  for (const char* text : {"", "{", "[]", "{}", R"({"keys": 3})", "null", R"({"keys": {}})"}) {
    EXPECT_THAT(key_faults(text), HasSubstr("is no JSON Web Key Set")) << text;
  }
  EXPECT_THAT(key_faults(R"({"keys": []})"), HasSubstr("has no key"));
  EXPECT_THAT(key_faults(R"({"keys": [], "keys": []})"), HasSubstr(R"(the member "keys" twice)"));
  EXPECT_THAT(key_faults(key_set(std::vector<Json>(201, key()))), HasSubstr("more than 200"));
}

}  // namespace
}  // namespace segserve::credentials
