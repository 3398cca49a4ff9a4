// SPDX-License-Identifier: Apache-2.0
#include "tls/tls_reload.hpp"

#include <filesystem>
#include <string>

#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "test/tls/test_certificates.hpp"

namespace segserve::tls {
namespace {

using testing::HasSubstr;

class TlsReloadTest : public testing::Test {
 protected:
  TlsFiles write(const TestIdentity& certificate, const TestIdentity& key) {
    return {.certificate = write_test_file("a.crt", certificate.certificate_pem()),
            .key = write_test_file("a.key", key.key_pem()),
            .authorities = write_test_file("ca.crt", authority_.certificate_pem())};
  }

  const TestIdentity authority_ = make_identity("authority");
  const TestIdentity one_ = make_identity("one", &authority_), two_ = make_identity("two", &authority_);
};

TEST_F(TlsReloadTest, TheFaultNamesItsFile) {
  const TlsFiles files = write(one_, two_);
  EXPECT_EQ(TlsReload::load(files).status().message(),
            files.certificate + " and " + files.key + ": the private key does not belong to the certificate");
  const TlsFiles missing{.certificate = files.certificate, .key = "/no/such.key", .authorities = ""};
  EXPECT_EQ(TlsReload::load(missing).status().message(), "cannot read /no/such.key: No such file or directory");
  TlsFiles no_authorities = write(one_, one_);
  no_authorities.authorities = write_test_file("ca.crt", "nothing");
  EXPECT_EQ(TlsReload::load(no_authorities).status().message(),
            no_authorities.authorities + ": there is no certificate in PEM");
  TlsFiles folder = write(one_, one_);
  folder.key = std::filesystem::path(folder.key).parent_path();
  EXPECT_THAT(std::string(TlsReload::load(folder).status().message()), HasSubstr("it is no regular file"));
  TlsFiles huge = write(one_, one_);
  huge.key = write_test_file("huge", std::string((std::size_t{4} << 20U) + 1, '\n'));
  EXPECT_THAT(std::string(TlsReload::load(huge).status().message()), HasSubstr("has more than 4194304 bytes"));
}

TEST_F(TlsReloadTest, TakesANewSetAtOnce) {
  auto reload = TlsReload::load(write(one_, one_));
  ASSERT_TRUE(reload.ok()) << reload.status();
  EXPECT_EQ(reload->poll(), std::nullopt);
  const auto before = reload->identity();
  write(two_, two_);
  EXPECT_EQ(reload->poll(), absl::OkStatus());
  EXPECT_NE(reload->identity(), before);
  EXPECT_EQ(reload->identity()->contents.certificate, two_.certificate_pem());
  EXPECT_EQ(reload->poll(), std::nullopt);
}

TEST_F(TlsReloadTest, KeepsTheOldSetAndReportsAWrongOneOnce) {
  auto reload = TlsReload::load(write(one_, one_));
  const auto before = reload->identity();
  const TlsFiles files = write(two_, one_);
  EXPECT_EQ(reload->poll(), std::nullopt) << "the key may be written next";
  const auto news = reload->poll();
  ASSERT_TRUE(news);
  EXPECT_THAT(std::string(news->message()), HasSubstr("does not belong"));
  EXPECT_EQ(reload->poll(), std::nullopt);
  EXPECT_EQ(reload->identity(), before);
  write_test_file("a.crt", "something else that is wrong");
  EXPECT_EQ(reload->poll(), std::nullopt);
  EXPECT_THAT(std::string(reload->poll()->message()), HasSubstr("no certificate"));
  std::filesystem::remove(files.key);
  EXPECT_EQ(reload->poll(), std::nullopt);
  EXPECT_THAT(std::string(reload->poll()->message()), HasSubstr("cannot read"));
  EXPECT_EQ(reload->poll(), std::nullopt);
  EXPECT_EQ(reload->identity(), before);
  write(two_, two_);
  EXPECT_EQ(reload->poll(), absl::OkStatus());
}

TEST_F(TlsReloadTest, TwoFilesThatAreWrittenOneAfterTheOtherAreNoFault) {
  auto reload = TlsReload::load(write(one_, one_));
  write(two_, one_);
  EXPECT_EQ(reload->poll(), std::nullopt);
  write(two_, two_);
  EXPECT_EQ(reload->poll(), absl::OkStatus());
}

TEST_F(TlsReloadTest, FollowsASymbolicLinkThatIsReplaced) {
  const TlsFiles files = write(one_, one_);
  const std::filesystem::path folder = std::filesystem::path(files.key).parent_path();
  for (const TestIdentity* identity : {&one_, &two_}) {
    const auto version = folder / (identity == &one_ ? "v1" : "v2");
    std::filesystem::create_directories(version);
    write_test_file((version.filename() / "tls.crt").string(), identity->certificate_pem());
    write_test_file((version.filename() / "tls.key").string(), identity->key_pem());
  }
  const auto link = folder / "data", fresh = folder / "data.new";
  std::filesystem::remove(link);
  std::filesystem::create_symlink("v1", link);
  auto reload = TlsReload::load({.certificate = link / "tls.crt", .key = link / "tls.key", .authorities = ""});
  ASSERT_TRUE(reload.ok()) << reload.status();
  std::filesystem::create_symlink("v2", fresh);
  std::filesystem::rename(fresh, link);
  EXPECT_EQ(reload->poll(), absl::OkStatus());
  EXPECT_EQ(reload->identity()->contents.certificate, two_.certificate_pem());
}

}  // namespace
}  // namespace segserve::tls
