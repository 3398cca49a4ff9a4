// SPDX-License-Identifier: Apache-2.0
#include "tls/certificates.hpp"

#include <chrono>
#include <string>

#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "test/tls/test_certificates.hpp"

namespace segserve::tls {
namespace {

using testing::HasSubstr;

TEST(Certificates, AreReadInTheirOrder) {
  const TestIdentity authority = make_identity("authority");
  const TestIdentity leaf = make_identity("leaf", &authority);
  const auto chain = parse_certificates("a remark\n" + leaf.certificate_pem() + authority.certificate_pem());
  ASSERT_TRUE(chain.ok()) << chain.status();
  ASSERT_EQ(chain->size(), 2U);
  EXPECT_EQ(text_of(X509_get_subject_name((*chain)[0].get())), "CN=leaf");
  EXPECT_EQ(text_of(X509_get_issuer_name((*chain)[0].get())), "CN=authority");
  EXPECT_EQ(text_of(X509_get_subject_name((*chain)[1].get())), "CN=authority");
}

TEST(Certificates, SaysWhichOneIsDamaged) {
  const std::string good = make_identity("good").certificate_pem();
  std::string cut = good;
  cut.erase(cut.size() / 2, 8);
  EXPECT_THAT(std::string(parse_certificates(good + cut).status().message()), HasSubstr("certificate 2 is damaged"));
  for (const std::string& text : {std::string(), std::string("no certificate"), make_identity("key").key_pem()}) {
    EXPECT_EQ(parse_certificates(text).status().message(), "there is no certificate in PEM");
  }
}

TEST(Certificates, NamesAreShownWithoutControlCharacters) {
  const TestIdentity odd = make_identity("a\nb\x1b[2J");
  EXPECT_EQ(text_of(X509_get_subject_name(odd.certificate.get())), "CN=a\\0Ab\\1B[2J");
}

TEST(Certificates, AChainIsValidAsLongAsAllOfIt) {
  const TestIdentity authority = make_identity("authority", nullptr, std::chrono::hours(1));
  const TestIdentity leaf = make_identity("leaf", &authority, std::chrono::hours(48));
  const auto chain = parse_certificates(leaf.certificate_pem() + authority.certificate_pem());
  const auto now = std::chrono::floor<std::chrono::seconds>(std::chrono::system_clock::now());
  EXPECT_LE(validity_of(*chain).end, now + std::chrono::hours(1));
  EXPECT_GT(validity_of(*chain).end, now + std::chrono::minutes(50));
  EXPECT_GT(validity_of(*leaf.certificate).end, now + std::chrono::hours(47));
}

TEST(Certificates, TimesAreShownInUtc) {
  using std::chrono::sys_seconds, std::chrono::seconds;
  EXPECT_EQ(text_of(sys_seconds(seconds(0))), "1970-01-01 00:00:00 UTC");
  EXPECT_EQ(text_of(sys_seconds(seconds(253'402'300'799))), "9999-12-31 23:59:59 UTC");
}

TEST(Key, IsRefusedIfItIsEncryptedOrNone) {
  const TestIdentity one = make_identity("one");
  EXPECT_TRUE(parse_key(one.key_pem()).ok());
  EXPECT_THAT(std::string(parse_key(one.key_pem("word")).status().message()), HasSubstr("is encrypted"));
  EXPECT_THAT(std::string(parse_key(one.certificate_pem()).status().message()), HasSubstr("no private key in PEM"));
  EXPECT_THAT(std::string(parse_key("").status().message()), HasSubstr("no private key in PEM"));
}

TEST(Pair, BelongsTogetherOrNot) {
  const TestIdentity authority = make_identity("authority");
  const TestIdentity one = make_identity("one", &authority);
  const TestIdentity other = make_identity("other", &authority);
  const auto chain = parse_certificates(one.certificate_pem() + authority.certificate_pem());
  EXPECT_TRUE(check_pair(*chain, *one.key).ok());
  EXPECT_EQ(check_pair(*chain, *other.key).message(), "the private key does not belong to the certificate");
  EXPECT_FALSE(check_pair(*chain, *authority.key).ok()) << "the key of the chain is not that of the certificate";
}

TEST(Pair, OfAKeyThatIsTooShortForTlsIsRefused) {
  TestIdentity weak = make_identity("weak");
  weak.key.reset(EVP_RSA_gen(512));
  X509_set_pubkey(weak.certificate.get(), weak.key.get());
  ASSERT_GT(X509_sign(weak.certificate.get(), weak.key.get(), EVP_sha256()), 0);
  const auto chain = parse_certificates(weak.certificate_pem());
  EXPECT_THAT(std::string(check_pair(*chain, *weak.key).message()), HasSubstr("key too small"));
}

}  // namespace
}  // namespace segserve::tls
