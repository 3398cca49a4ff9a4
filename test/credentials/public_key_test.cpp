// SPDX-License-Identifier: Apache-2.0
#include "credentials/public_key.hpp"

#include <string>

#include "credentials/base64url.hpp"
#include "gtest/gtest.h"
#include "test/credentials/signing_key.hpp"

namespace segserve::credentials {
namespace {

std::string bytes(const char* text) { return from_base64url(text).value(); }

// The examples of the standards.

TEST(PublicKey, ChecksTheRs256OfRfc7515) {
  const auto key = PublicKey::rsa(
      bytes(
          "ofgWCuLjybRlzo0tZWJjNiuSfb4p4fAkd_wWJcyQoTbji9k0l8W26mPddxHmfHQp-Vaw-4qPCJrcS2mJPMEzP1Pt0Bm4d4QlL-yRT-SFd2lZ"
          "S-pCgNMsD1W_YpRPEwOWvG6b32690r2jZ47soMZo9wGzjb_7OMg0LOL-bSf63kpaSHSXndS5z5rexMdbBYUsLA9e-KXBdQOS-UTo7WTBEMa2"
          "R2CapHg665xsmtdVMTBQY4uDZlxvb3qCo5ZwKh9kG4LT6_I5IhlJH7aGhyxXFvUK-DWNmoudF8NAco9_h9iaGNj8q2ethFkMLs91kzk2PAcD"
          "TW9gb54h4FRWyuXpoQ"),
      bytes("AQAB"));
  ASSERT_TRUE(key.ok()) << key.status();
  const std::string text =
      "eyJhbGciOiJSUzI1NiJ9."
      "eyJpc3MiOiJqb2UiLA0KICJleHAiOjEzMDA4MTkzODAsDQogImh0dHA6Ly9leGFtcGxlLmNvbS9pc19yb290Ijp0cnVlfQ";
  const std::string signature = bytes(
      "cC4hiUPoj9Eetdgtv3hF80EGrhuB__dzERat0XF9g2VtQgr9PJbu3XOiZj5RZmh7AAuHIm4Bh-0Qc_lF5YKt_O8W2Fp5jujGbds9uJdbF9CUAr"
      "7t1dnZcAcQjbKBYNX4BAynRFdiuB--f_nZLgrnbyTyWzO75vRK5h6xBArLIARNPvkSjtQBMHlb1L07Qe7K0GarZRmB_eSN9383LcOLn6_dO--x"
      "i12jzDwusC-eOkHWEsqtFZESc6BfI7noOPqvhJ1phCnvWh6IeYI2w9QOYEUipUTI8np6LbgGY9Fs98rqVt5AXLIhWkWywlVmtVrBp0igcN_Ioy"
      "pGlUPQGe77Rw");
  EXPECT_TRUE(key->verifies(text, signature));
  EXPECT_FALSE(key->verifies(text + "A", signature));
  EXPECT_FALSE(key->verifies(text, signature.substr(1)));
  EXPECT_FALSE(key->verifies(text, ""));
}

TEST(PublicKey, ChecksTheEs256OfRfc7515) {
  const auto key = PublicKey::p256(bytes("f83OJ3D2xF1Bg8vub9tLe1gHMzV76e8Tus9uPHvRVEU"),
                                   bytes("x_FEzRu9m36HLN_tue659LNpXW6pCyStikYjKIWI5a0"));
  ASSERT_TRUE(key.ok()) << key.status();
  const std::string text =
      "eyJhbGciOiJFUzI1NiJ9."
      "eyJpc3MiOiJqb2UiLA0KICJleHAiOjEzMDA4MTkzODAsDQogImh0dHA6Ly9leGFtcGxlLmNvbS9pc19yb290Ijp0cnVlfQ";
  const std::string signature =
      bytes("DtEhU3ljbEg8L38VWAfUAqOyKAM6-Xx-F4GawxaepmXFCgfTjDxw5djxLa8ISlSApmWQxfKTUJqPP3-Kg6NU1Q");
  EXPECT_TRUE(key->verifies(text, signature));
  EXPECT_FALSE(key->verifies(text + "A", signature));
  EXPECT_FALSE(key->verifies(text, signature + std::string(1, '\0')));
  EXPECT_FALSE(key->verifies(text, std::string(64, '\0'))) << "CVE-2022-21449";
}

TEST(PublicKey, ChecksTheEd25519OfRfc8037) {
  const auto key = PublicKey::ed25519(bytes("11qYAYKxCrfVS_7TyWQHOg7hcvPapiMlrwIaaPcHURo"));
  ASSERT_TRUE(key.ok()) << key.status();
  const std::string text = "eyJhbGciOiJFZERTQSJ9.RXhhbXBsZSBvZiBFZDI1NTE5IHNpZ25pbmc";
  const std::string signature =
      bytes("hgyY0il_MGCjP0JzlnLWG1PPOt7-09PGcvMg3AIbQR6dWbhijcNR4ki4iylGjg5BhVsPt9g7sVvpAr_MuM0KAg");
  EXPECT_TRUE(key->verifies(text, signature));
  EXPECT_FALSE(key->verifies(text + "A", signature));
  EXPECT_FALSE(key->verifies(text, signature.substr(1)));
}

TEST(PublicKey, IsNoneIfItIsWeakOrDamaged) {
  const std::string strong(256, '\xff'), exponent("\1\0\1", 3);
  EXPECT_TRUE(PublicKey::rsa(strong, exponent).ok());
  EXPECT_FALSE(PublicKey::rsa(std::string(255, '\xff'), exponent).ok());
  EXPECT_FALSE(PublicKey::rsa(std::string(1025, '\xff'), exponent).ok()) << "it takes long to check";
  EXPECT_FALSE(PublicKey::rsa(std::string(5000, '\0') + strong, exponent).ok());
  for (const std::string& wrong : {std::string("\1"), std::string("\2"), std::string(), std::string(5, '\xff')}) {
    EXPECT_FALSE(PublicKey::rsa(strong, wrong).ok());
  }
  EXPECT_FALSE(PublicKey::p256(std::string(32, '\1'), std::string(32, '\1')).ok()) << "it is not on the curve";
  EXPECT_FALSE(PublicKey::p256(std::string(32, '\0'), std::string(32, '\0')).ok());
  EXPECT_FALSE(PublicKey::p256(std::string(31, '\1'), std::string(32, '\1')).ok());
  EXPECT_FALSE(PublicKey::ed25519(std::string(31, '\1')).ok());
}

TEST(PublicKey, AlgorithmsWithSharedSecretsAreUnknown) {
  for (const char* name : {"none", "None", "", "HS256", "HS512", "RS512", "PS256", "ES384", "rs256"}) {
    EXPECT_EQ(algorithm_from_name(name), std::nullopt) << name;
  }
  EXPECT_EQ(algorithm_from_name("EdDSA"), SignatureAlgorithm::kEdDsa);
}

}  // namespace
}  // namespace segserve::credentials
