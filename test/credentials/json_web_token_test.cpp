// SPDX-License-Identifier: Apache-2.0
#include "credentials/json_web_token.hpp"

#include <openssl/hmac.h>

#include <string>

#include "gmock/gmock.h"
#include "test/credentials/signing_key.hpp"

namespace segserve::credentials {
namespace {

using namespace std::chrono_literals;
using Json = nlohmann::json;
using testing::HasSubstr;

const std::chrono::system_clock::time_point kNow{std::chrono::seconds(1'800'000'000)};
const JwtPolicy kPolicy{"https://idp.example", "segserve"};

Json claims() {
  return {{"iss", kPolicy.issuer}, {"aud", kPolicy.audience}, {"sub", "robot-7"}, {"exp", seconds_of(kNow + 1h)}};
}

Json claims(const char* name, const Json& value) {
  Json changed = claims();
  changed[name] = value;
  return changed;
}

Json claims_without(const char* name) {
  Json changed = claims();
  changed.erase(name);
  return changed;
}

class JsonWebToken : public testing::Test {
 protected:
  absl::StatusOr<JwtClaims> verify(const std::string& token) const { return verify_jwt(token, keys_, kPolicy, kNow); }

  void refuse(const std::string& token, const std::string& why) const {
    const auto verified = verify(token);
    EXPECT_TRUE(absl::IsUnauthenticated(verified.status())) << token;
    EXPECT_THAT(std::string(verified.status().message()), HasSubstr(why)) << token;
  }
  void refuse_claims(const Json& claims, const std::string& why) const { refuse(key_.token(claims), why); }

  const SigningKey key_{"EdDSA"}, rsa_{"RS256", "rsa"}, ec_{"ES256", "ec"};
  const JsonWebKeys keys_ =
      parse_json_web_keys(key_set({key_.public_half(), rsa_.public_half(), ec_.public_half()}), "keys").value();
};

TEST_F(JsonWebToken, IsAcceptedFromEveryKindOfKey) {
  for (const SigningKey* key : {&key_, &rsa_, &ec_}) {
    const auto verified = verify(key->token(claims()));
    ASSERT_TRUE(verified.ok()) << verified.status();
    EXPECT_EQ(verified->subject, "robot-7");
    EXPECT_EQ(verified->not_after, kNow + 1h + kJwtLeeway);
  }
  EXPECT_EQ(verify(ec_.token(claims()))->key, keys_[2]);
}

TEST_F(JsonWebToken, MayHaveMoreThanItNeeds) {
  for (const Json& good : {claims("aud", {"other", "segserve"}), claims("nbf", seconds_of(kNow)),
                           claims("iat", seconds_of(kNow + 20s)), claims("nbf", seconds_of(kNow + 30s)),
                           claims("exp", static_cast<double>(seconds_of(kNow)) + 0.5), claims("scope", "all")}) {
    EXPECT_TRUE(verify(key_.token(good)).ok()) << good;
  }
  Json header = key_.header();
  for (const char* type : {"at+jwt", "application/at+JWT", "jwt"}) {
    header["typ"] = type;
    EXPECT_TRUE(verify(key_.token(header, claims().dump())).ok()) << type;
  }
  header.erase("typ");
  EXPECT_TRUE(verify(key_.token(header, claims().dump())).ok());
}

TEST_F(JsonWebToken, ThatHasExpiredTellsWhen) {
  const auto verified = verify(key_.token(claims("exp", seconds_of(kNow - 1h))));
  ASSERT_TRUE(verified.ok()) << verified.status();
  EXPECT_LT(verified->not_after, kNow);
}

TEST_F(JsonWebToken, MayHaveAnEndThatIsFarAway) {
  const auto verified = verify(key_.token(claims("exp", 253402300799)));  // the year 9999
  ASSERT_TRUE(verified.ok()) << verified.status();
  EXPECT_GT(verified->not_after, kNow + std::chrono::hours(24 * 365 * 100));
}

TEST_F(JsonWebToken, IsRefusedForWhatItClaims) {
  refuse_claims(claims("iss", "https://idp.example/"), "issuer");
  refuse_claims(claims("iss", {kPolicy.issuer}), "issuer");
  refuse_claims(claims_without("iss"), "issuer");
  refuse_claims(claims("aud", "other"), "audience");
  refuse_claims(claims("aud", {"other", "segserv"}), "audience");
  refuse_claims(claims("aud", Json::array()), "audience");
  refuse_claims(claims("aud", 3), "audience");
  refuse_claims(claims_without("aud"), "audience");
  refuse_claims(claims("nbf", seconds_of(kNow + 31s)), "not valid yet");
  refuse_claims(claims("iat", seconds_of(kNow + 31s)), "issued in the future");
  refuse_claims(claims_without("exp"), "no 'exp'");
  for (const Json& time : {Json("soon"), Json(-5), Json(1e300), Json(true), Json()}) {
    refuse_claims(claims("exp", time), "'exp' is no time");
    refuse_claims(claims("nbf", time), "'nbf' is no time");
  }
  for (const Json& subject : {Json(""), Json(3), Json("a\nb"), Json(std::string(257, 'a'))}) {
    refuse_claims(claims("sub", subject), "subject");
  }
  refuse_claims(claims_without("sub"), "subject");
}

TEST_F(JsonWebToken, IsRefusedForItsKey) {
  refuse(SigningKey("EdDSA").token(claims()), "signature");
  refuse(SigningKey("EdDSA", "other").token(claims()), "no key has its 'kid'");
  refuse(SigningKey("EdDSA", "").token(claims()), "no 'kid'");
}

TEST_F(JsonWebToken, CannotChooseItsAlgorithm) {
  Json header = rsa_.header();
  for (const char* algorithm : {"none", "None", "nOnE", "", "HS256", "RS512", "PS256"}) {
    header["alg"] = algorithm;
    refuse(rsa_.token(header, claims().dump()), "algorithm is not RS256, ES256 or EdDSA");
    const std::string token = rsa_.token(header, claims().dump());
    refuse(token.substr(0, token.rfind('.') + 1), "algorithm");
  }
  header["alg"] = "ES256";
  refuse(rsa_.token(header, claims().dump()), "not that of its key");

  // The public key as the secret of an HMAC, which fools checks that believe the header.
  header["alg"] = "HS256";
  const std::string secret = rsa_.public_half().dump(),
                    text = to_base64url(header.dump()) + "." + to_base64url(claims().dump());
  unsigned char mac[EVP_MAX_MD_SIZE];
  unsigned size = 0;
  HMAC(EVP_sha256(), secret.data(), static_cast<int>(secret.size()),
       reinterpret_cast<const unsigned char*>(text.data()), text.size(), mac, &size);
  refuse(text + "." + to_base64url({reinterpret_cast<const char*>(mac), size}), "algorithm");
}

TEST_F(JsonWebToken, IsRefusedForItsHeader) {
  Json header = key_.header();
  header["crit"] = {"exp"};
  refuse(key_.token(header, claims().dump()), "critical");
  header = key_.header();
  header["typ"] = "dpop+jwt";
  refuse(key_.token(header, claims().dump()), "'typ'");
  header["typ"] = 3;
  refuse(key_.token(header, claims().dump()), "'typ'");
  header = key_.header();
  header["jwk"] = SigningKey("EdDSA").public_half();
  EXPECT_TRUE(verify(key_.token(header, claims().dump())).ok()) << "keys in a token do not count";
  refuse(SigningKey("EdDSA").token(header, claims().dump()), "signature");
}

TEST_F(JsonWebToken, CannotBeChanged) {
  for (const SigningKey* key : {&key_, &rsa_, &ec_}) {
    const std::string token = key->token(claims());
    for (std::size_t i = 0; i < token.size(); i += 3) {
      std::string changed = token;
      changed[i] = changed[i] == 'A' ? 'B' : 'A';
      EXPECT_FALSE(verify(changed).ok()) << i;
      EXPECT_FALSE(verify(token.substr(0, i)).ok()) << i;
    }
    EXPECT_FALSE(verify(token + "=").ok());
    EXPECT_FALSE(verify(token + ".").ok());
    EXPECT_FALSE(verify(" " + token).ok());
  }
  const std::string token = key_.token(claims()), other = key_.token(claims("sub", "admin"));
  refuse(other.substr(0, other.rfind('.')) + token.substr(token.rfind('.')), "signature");
}

TEST_F(JsonWebToken, HasABound) {
  refuse(key_.token(claims("more", std::string(8192, 'a'))), "more than 8192 bytes");
  refuse("", "three parts");
  refuse(std::string(5000, '.'), "three parts");
  refuse("..", "header");
  refuse("e30.e30.", "algorithm");
  refuse(to_base64url(std::string(5000, '[')) + ".e30.e30", "header");
}

TEST_F(JsonWebToken, ClaimsNothingTwice) {
  std::string payload = claims().dump();
  payload.insert(1, R"("sub":"robot-1",)");
  refuse(key_.token(key_.header(), payload), R"(the payload: it has an object with the member "sub" twice)");
}

TEST_F(JsonWebToken, ThatIsSignedMayStillBeNonsense) {
  for (const char* payload : {"", "[]", "3", "null", "{", "{\"sub\":\"\xff\"}"}) {
    refuse(key_.token(key_.header(), payload), "payload");
  }
}

TEST_F(JsonWebToken, IsInNoMessage) {
  const std::string token = key_.token(claims("aud", "elsewhere"));
  const std::string message(verify(token).status().message());
  for (const char* part : {"robot-7", "elsewhere"}) EXPECT_THAT(message, testing::Not(HasSubstr(part)));
}

}  // namespace
}  // namespace segserve::credentials
