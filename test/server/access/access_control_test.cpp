// SPDX-License-Identifier: Apache-2.0
#include "server/access/access_control.hpp"

#include <filesystem>
#include <fstream>
#include <string>

#include "fmt/format.h"
#include "gmock/gmock.h"
#include "proto/wire/status_message.hpp"
#include "test/credentials/signing_key.hpp"

namespace segserve::server {
namespace {

using namespace std::chrono_literals;
using credentials::SigningKey;
using testing::HasSubstr;

std::string entry(const std::string& subject, const std::string& token, const std::string& more = "") {
  return fmt::format("[[token]]\nsubject = \"{}\"\nsha256 = \"{}\"\n{}", subject,
                     credentials::to_hex(credentials::hash_of(token)), more);
}

wire::ErrorReason refusal_reason(const absl::Status& status) {
  EXPECT_TRUE(absl::IsUnauthenticated(status)) << status;
  return wire::details_of(status).reason;
}

class AccessControlTest : public testing::Test {
 protected:
  AccessControlTest() { std::filesystem::create_directories(folder_); }
  ~AccessControlTest() override { std::filesystem::remove_all(folder_); }

  std::string write(const std::string& name, const std::string& content) const {
    std::ofstream(folder_ / name) << content;
    return folder_ / name;
  }
  std::unique_ptr<AccessControl> open(const std::string& tokens, const std::string& keys = "") const {
    AccessOptions options{.tokens = write("t.toml", tokens)};
    if (!keys.empty()) {
      options.jwt_keys = write("k.json", keys);
      options.jwt_issuer = "https://idp";
      options.jwt_audience = "segserve";
    }
    return AccessControl::open(options, [this] { return now_; }).value();
  }
  /// A change is taken when it was seen twice.
  static void take_changes(AccessControl& control) {
    control.look_for_changes();
    control.look_for_changes();
  }

  nlohmann::json claims(const std::string& subject) const {
    return {{"iss", "https://idp"}, {"aud", "segserve"}, {"sub", subject}, {"exp", credentials::seconds_of(now_ + 1h)}};
  }

  const std::filesystem::path folder_ =
      std::filesystem::path(testing::TempDir()) / testing::UnitTest::GetInstance()->current_test_info()->name();
  credentials::WallTime now_{1'800'000'000s};
};

PresentedProofs bearer(const std::string& header) { return {.authorizations = {header}}; }

TEST_F(AccessControlTest, WithoutFilesEverybodyMayCall) {
  const auto control = AccessControl::open({}).value();
  const auto grant = control->admit({});
  ASSERT_TRUE(grant.ok());
  EXPECT_EQ(grant->subject(), "");
  EXPECT_EQ(control->admit(bearer("Bearer x"))->subject(), "") << "a server that asks for none ignores tokens";
}

TEST_F(AccessControlTest, ATokenTellsItsSubject) {
  const auto control = open(entry("robot-7", "abc") + entry("robot-8", "def"));
  for (const std::string header : {"Bearer abc", "bearer abc", "BEARER   abc"}) {
    const auto grant = control->admit(bearer(header));
    ASSERT_TRUE(grant.ok()) << header;
    EXPECT_EQ(grant->subject(), "robot-7");
  }
  EXPECT_EQ(control->admit(bearer("Bearer def"))->subject(), "robot-8");
}

TEST_F(AccessControlTest, OtherCallersAreRefused) {
  const auto control = open(entry("robot-7", "abc"));
  EXPECT_EQ(refusal_reason(control->admit({}).status()), wire::ErrorReason::kTokenMissing);
  for (const std::string header :
       {"Bearer abd", "Bearer ", "Bearer", "Basic abc", "abc", "", "Bearer abc ", "Bearer a.b.c"}) {
    EXPECT_EQ(refusal_reason(control->admit(bearer(header)).status()), wire::ErrorReason::kTokenInvalid) << header;
  }
  EXPECT_EQ(refusal_reason(control->admit({.authorizations = {"Bearer abc", "Bearer abc"}}).status()),
            wire::ErrorReason::kTokenInvalid);
  const std::string hash = "Bearer " + credentials::to_hex(credentials::hash_of("abc"));
  EXPECT_EQ(refusal_reason(control->admit(bearer(hash)).status()), wire::ErrorReason::kTokenInvalid);
}

TEST_F(AccessControlTest, ATokenEndsWithItsTime) {
  const auto control = open(entry("robot-7", "abc", "not_after = 2027-01-15T08:00:01Z\n"));
  auto grant = control->admit(bearer("Bearer abc"));
  ASSERT_TRUE(grant.ok());
  EXPECT_TRUE(grant->check().ok());
  now_ += 1s;
  EXPECT_EQ(refusal_reason(grant->check()), wire::ErrorReason::kTokenExpired);
  EXPECT_EQ(refusal_reason(control->admit(bearer("Bearer abc")).status()), wire::ErrorReason::kTokenExpired);
}

TEST_F(AccessControlTest, AFileThatChangesIsUsedWithoutBreakingAnything) {
  const auto control = open(entry("robot-7", "abc") + entry("robot-8", "def"));
  auto kept = control->admit(bearer("Bearer abc")), withdrawn = control->admit(bearer("Bearer def"));
  write("t.toml", entry("robot-7", "abc") + entry("robot-7", "new") + entry("robot-9", "def2"));
  control->look_for_changes();
  EXPECT_TRUE(withdrawn->check().ok()) << "the file may still be written";
  control->look_for_changes();
  EXPECT_TRUE(kept->check().ok());
  EXPECT_EQ(refusal_reason(withdrawn->check()), wire::ErrorReason::kTokenInvalid);
  EXPECT_EQ(control->admit(bearer("Bearer new"))->subject(), "robot-7");
  EXPECT_EQ(control->reloads().done, 1U);
}

TEST_F(AccessControlTest, ATokenThatGoesToAnotherSubjectIsWithdrawn) {
  const auto control = open(entry("robot-7", "abc"));
  auto grant = control->admit(bearer("Bearer abc"));
  write("t.toml", entry("robot-8", "abc"));
  take_changes(*control);
  EXPECT_EQ(refusal_reason(grant->check()), wire::ErrorReason::kTokenInvalid);
}

TEST_F(AccessControlTest, AFileWithFaultsChangesNothing) {
  const auto control = open(entry("robot-7", "abc"));
  auto grant = control->admit(bearer("Bearer abc"));
  for (const std::string content : {"[[token", "frames = 3\n"}) {
    write("t.toml", content);
    for (int i = 0; i < 4; ++i) control->look_for_changes();
    EXPECT_TRUE(grant->check().ok());
    EXPECT_TRUE(control->admit(bearer("Bearer abc")).ok());
  }
  EXPECT_EQ(control->reloads().failed, 2U) << "each is told once";
  std::filesystem::remove(folder_ / "t.toml");
  take_changes(*control);
  EXPECT_TRUE(control->admit(bearer("Bearer abc")).ok());
  EXPECT_EQ(control->reloads().failed, 3U);
  EXPECT_EQ(control->reloads().done, 0U);
}

TEST_F(AccessControlTest, AFileThatHasLostItsTokensChangesNothing) {
  const auto control = open(entry("robot-7", "abc"));
  for (const std::string content : {"", "# nothing\n", "[default]\nframes_per_second = 1\n"}) {
    write("t.toml", content);
    take_changes(*control);
    EXPECT_TRUE(control->admit(bearer("Bearer abc")).ok()) << content;
  }
  EXPECT_EQ(control->reloads().failed, 3U);
  write("t.toml", entry("robot-7", "abc", "not_after = 2020-01-01T00:00:00Z\n"));
  take_changes(*control);
  EXPECT_EQ(refusal_reason(control->admit(bearer("Bearer abc")).status()), wire::ErrorReason::kTokenExpired)
      << "so the last token is withdrawn";
}

TEST_F(AccessControlTest, AFileMayBeginWithoutTokens) {
  const auto control = open("[default]\nframes_per_second = 1\n");
  write("t.toml", "");
  take_changes(*control);
  EXPECT_EQ(control->reloads().done, 1U);
  write("t.toml", entry("robot-7", "abc"));
  take_changes(*control);
  EXPECT_TRUE(control->admit(bearer("Bearer abc")).ok());
}

TEST_F(AccessControlTest, FilesWithFaultsAreAllToldAtTheStart) {
  const AccessOptions options{.tokens = write("t.toml", "a = 1"), .jwt_keys = write("k.json", "{}")};
  const auto control = AccessControl::open(options);
  EXPECT_THAT(std::string(control.status().message()),
              testing::AllOf(HasSubstr("t.toml:1: there is no 'a'"), HasSubstr("k.json is no JSON Web Key Set")));
  EXPECT_TRUE(absl::IsNotFound(AccessControl::open({.tokens = folder_ / "nothing"}).status()));
}

TEST_F(AccessControlTest, LimitsAreThoseOfTheSubjectWhateverItsToken) {
  const auto control = open("[default]\nhighest_priority = 1\n[subject.robot-7]\nframes_per_second = 1\n" +
                            entry("robot-7", "abc") + entry("robot-7", "def"));
  const auto one = control->admit(bearer("Bearer abc")), other = control->admit(bearer("Bearer def"));
  EXPECT_TRUE(one->admit(1, 1).ok());
  EXPECT_TRUE(absl::IsResourceExhausted(other->admit(1, 1).status()));
  EXPECT_EQ(one->priority(5), 1);
  EXPECT_EQ(one->priority(-5), -5);
  write("t.toml", "[subject.robot-7]\nbytes_in_flight = 10\n" + entry("robot-7", "abc"));
  take_changes(*control);
  EXPECT_EQ(one->priority(5), 5);
  EXPECT_EQ(one->most_bytes(), 10U);
  EXPECT_TRUE(one->admit(1, 1).ok());
}

TEST_F(AccessControlTest, AnAnonymousCallerHasNoLimits) {
  AccessGrant grant;
  EXPECT_TRUE(grant.check().ok());
  EXPECT_TRUE(grant.admit(1'000'000'000, 1'000'000'000).ok());
  EXPECT_EQ(grant.priority(7), 7);
}

TEST_F(AccessControlTest, ACertificateIsAProof) {
  const auto control = open("[subject.\"cert:spiffe://site/robot\"]\nhighest_priority = 2\n" + entry("robot-7", "abc"));
  const auto grant = control->admit({.certificate_name = "spiffe://site/robot"});
  ASSERT_TRUE(grant.ok()) << grant.status();
  EXPECT_EQ(grant->subject(), "cert:spiffe://site/robot");
  EXPECT_EQ(grant->priority(5), 2);
  EXPECT_EQ(control->admit({.authorizations = {"Bearer abc"}, .certificate_name = "robot"})->subject(), "robot-7")
      << "a token goes before a certificate";
  EXPECT_FALSE(control->admit({.authorizations = {"Bearer x"}, .certificate_name = "robot"}).ok());
}

TEST_F(AccessControlTest, AJwtIsAProof) {
  const SigningKey key("EdDSA");
  const auto control = open("[subject.\"https://idp/robot\"]\nhighest_priority = 2\n" + entry("robot-7", "abc"),
                            credentials::key_set({key.public_half()}));
  const std::string header = "Bearer " + key.token(claims("robot"));
  for (int i = 0; i < 2; ++i) {  // the second time it is remembered
    auto grant = control->admit(bearer(header));
    ASSERT_TRUE(grant.ok()) << grant.status();
    EXPECT_EQ(grant->subject(), "https://idp/robot");
    EXPECT_EQ(grant->priority(5), 2);
  }
  EXPECT_EQ(refusal_reason(control->admit(bearer(header + "A")).status()), wire::ErrorReason::kTokenInvalid);
  EXPECT_TRUE(control->admit(bearer("Bearer abc")).ok()) << "both kinds are accepted";

  auto grant = control->admit(bearer(header));
  now_ += 1h + 29s;
  EXPECT_TRUE(grant->check().ok());
  now_ += 1s;
  EXPECT_EQ(refusal_reason(grant->check()), wire::ErrorReason::kTokenExpired);
  EXPECT_EQ(refusal_reason(control->admit(bearer(header)).status()), wire::ErrorReason::kTokenExpired);
}

TEST_F(AccessControlTest, AJwtEndsWithItsKey) {
  const SigningKey old_key("EdDSA", "old"), new_key("EdDSA", "new");
  const auto control = open("", credentials::key_set({old_key.public_half()}));
  const std::string header = "Bearer " + old_key.token(claims("robot"));
  auto grant = control->admit(bearer(header));
  write("k.json", credentials::key_set({new_key.public_half(), old_key.public_half()}));
  take_changes(*control);
  EXPECT_TRUE(grant->check().ok());
  EXPECT_TRUE(control->admit(bearer("Bearer " + new_key.token(claims("robot")))).ok());
  write("k.json", credentials::key_set({new_key.public_half(), SigningKey("EdDSA", "old").public_half()}));
  take_changes(*control);
  EXPECT_EQ(refusal_reason(grant->check()), wire::ErrorReason::kTokenInvalid) << "another key has its name";
  EXPECT_EQ(refusal_reason(control->admit(bearer(header)).status()), wire::ErrorReason::kTokenInvalid)
      << "what was remembered does not count any more";
}

TEST(VerifiedJwts, RememberABoundedNumber) {
  const auto files = std::make_shared<const AccessFiles>();
  const auto key =
      credentials::parse_json_web_keys(credentials::key_set({SigningKey("EdDSA").public_half()}), "k").value();
  VerifiedJwts jwts(3);
  const auto add = [&](const char* name) {
    jwts.add(credentials::hash_of(name), files, {.subject = name, .not_after = {}, .key = key[0]});
  };
  const auto has = [&](const char* name) { return jwts.find(credentials::hash_of(name), files).has_value(); };
  for (const char* name : {"a", "b", "c"}) add(name);
  EXPECT_TRUE(has("a"));
  add("d");
  EXPECT_FALSE(has("b")) << "it was used longest ago";
  EXPECT_TRUE(has("a") && has("c") && has("d"));
  EXPECT_FALSE(jwts.find(credentials::hash_of("a"), std::make_shared<const AccessFiles>()).has_value());
}

}  // namespace
}  // namespace segserve::server
