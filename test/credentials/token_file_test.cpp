// SPDX-License-Identifier: Apache-2.0
#include "credentials/token_file.hpp"

#include <cmath>
#include <string>

#include "fmt/format.h"
#include "gmock/gmock.h"

namespace segserve::credentials {
namespace {

using namespace std::chrono_literals;

TokenFile parse(const std::string& text) {
  const auto file = parse_token_file(text, "t.toml");
  EXPECT_TRUE(file.ok()) << file.status();
  return file.value_or(TokenFile());
}

std::string faults_of(const std::string& text) {
  const auto file = parse_token_file(text, "t.toml");
  EXPECT_TRUE(absl::IsInvalidArgument(file.status())) << text;
  return std::string(file.status().message());
}

std::string token_of(const std::string& subject, const std::string& token) {
  return fmt::format("[[token]]\nsubject = \"{}\"\nsha256 = \"{}\"\n", subject, to_hex(hash_of(token)));
}

TEST(TokenFile, FindsATokenByItsHash) {
  const TokenFile file = parse(token_of("a", "1") + token_of("b", "2") + token_of("a", "3"));
  ASSERT_NE(file.find(hash_of("3")), nullptr);
  EXPECT_EQ(file.find(hash_of("3"))->subject, "a");
  EXPECT_EQ(file.find(hash_of("2"))->subject, "b");
  EXPECT_EQ(file.find(hash_of("4")), nullptr);
  EXPECT_EQ(file.find(TokenHash{}), nullptr);
}

TEST(TokenFile, MayBeEmpty) {
  EXPECT_TRUE(parse("").tokens.empty());
  EXPECT_EQ(parse("# nothing\n").limits_of("a"), SubjectLimits{});
}

TEST(TokenFile, ATokenMayHaveAnEnd) {
  const TokenFile file = parse(token_of("a", "1") + "not_after = 2027-01-01T00:30:00.5+02:00\n" + token_of("b", "2"));
  const WallTime expected = std::chrono::sys_days{std::chrono::December / 31 / 2026} + 22h + 30min;
  EXPECT_EQ(file.tokens[0].not_after, expected);
  EXPECT_EQ(file.tokens[1].not_after, std::nullopt);
}

TEST(TokenFile, AnEndIsWithinTheTimeOfTheClock) {
  for (const char* year : {"0001", "1013", "1969", "2201", "9999"}) {
    EXPECT_THAT(faults_of(token_of("a", "1") + fmt::format("not_after = {}-01-01T00:00:00Z\n", year)),
                testing::HasSubstr("from 1970 to 2200"));
  }
}

TEST(TokenFile, ASubjectHasItsOwnLimitsAndTheDefaults) {
  const TokenFile file = parse(R"([default]
frames_per_second = 30
points_per_second = 1e6
highest_priority = -2
[subject."https://idp.example/robot"]
frames_per_second = 0.5
bytes_in_flight = 1_000
[subject.free]
frames_per_second = inf
)");
  const SubjectLimits limits = file.limits_of("https://idp.example/robot");
  EXPECT_EQ(limits.frames_per_second, 0.5);
  EXPECT_EQ(limits.points_per_second, 1e6);
  EXPECT_EQ(limits.bytes_in_flight, 1000U);
  EXPECT_EQ(limits.highest_priority, -2);
  EXPECT_EQ(file.limits_of("anybody").frames_per_second, 30);
  EXPECT_EQ(file.limits_of("anybody").bytes_in_flight, std::nullopt);
  EXPECT_TRUE(std::isinf(*file.limits_of("free").frames_per_second));
}

TEST(TokenFile, TellsEveryFaultWithItsLine) {
  EXPECT_EQ(faults_of(R"([default]
frames_per_second = 0
points_per_second = "many"
bytes_in_flight = 1.5
highest_priority = 3_000_000_000
frames = 3
[subject]
a = 3
[[token]]
[[token]]
subject = "a/b"
sha256 = "12"
not_after = 2027-01-01T00:00:00
token = "x"
)"),
            "t.toml:2: frames_per_second: it must be a number above 0; "
            "t.toml:3: points_per_second: it must be a number above 0; "
            "t.toml:4: bytes_in_flight: it must be a whole number of at least 1; "
            "t.toml:5: highest_priority: it must be a whole number of at least -2147483648; "
            "t.toml:6: there is no 'frames'; there are frames_per_second, points_per_second, bytes_in_flight, "
            "highest_priority; "
            "t.toml:8: 'a' is no table; "
            "t.toml:9: the token has no subject; t.toml:9: the token has no sha256; "
            "t.toml:11: subject: a name has 1 to 64 letters, digits, '.', '_', '-' or '@'; "
            "t.toml:12: sha256: it must be a text of 64 hexadecimal digits, as `segctl token` makes it; "
            "t.toml:13: not_after: it must be a time with its offset, such as 2027-01-01T00:00:00Z, from 1970 to 2200; "
            "t.toml:14: there is no 'token'; there are subject, sha256, not_after");
}

TEST(TokenFile, IsRefusedIfItIsOfAnotherShape) {
  EXPECT_THAT(faults_of("[default\n"), testing::StartsWith("t.toml:1: "));
  EXPECT_EQ(
      faults_of("token = 3\ndefault = 4\nsubject = 5\n"),
      "t.toml:1: a token begins with [[token]]; t.toml:2: 'default' is no table; t.toml:3: 'subject' is no table");
  EXPECT_EQ(faults_of("token = [3]\n"), "t.toml:1: 'token' is no table");
  for (const char* no_name : {"[&]", "[[&", "a.& = 1", "a = {& = 1}"}) {
    EXPECT_THAT(faults_of(no_name), testing::StartsWith("t.toml:1: ")) << no_name;
  }
  EXPECT_THAT(faults_of("[[token]]\nsubject = 3\nsha256 = 4\n"), testing::HasSubstr("t.toml:2: subject"));
  EXPECT_THAT(faults_of("[default]\nfoo = 1\n[default]\n"), testing::StartsWith("t.toml:3: "));
}

TEST(TokenFile, IsAscii) {
  EXPECT_THAT(faults_of("[default]\nframes\xef\xbb\xb7 = 1\n"),
              testing::StartsWith("t.toml:2: there is a letter beyond"));
  EXPECT_EQ(parse("[subject.\"\\u00e4\"]\nhighest_priority = 3\n").limits_of("\xc3\xa4").highest_priority, 3);
}

TEST(TokenFile, ATokenIsOneSubjects) {
  EXPECT_EQ(faults_of(token_of("a", "1") + token_of("b", "1")), "t.toml:6: sha256: the file has this token already");
}

TEST(TokenFile, BoundsWhatItTells) {
  std::string text;
  for (int i = 0; i < 100; ++i) text += fmt::format("x{} = 1\n", i);
  EXPECT_THAT(faults_of(text), testing::EndsWith("; and 80 more faults"));
}

TEST(SubjectName, CannotBeThatOfAnotherKindOfProof) {
  for (const char* good : {"a", "robot-7", "a.b_c@site", "0"}) EXPECT_TRUE(is_subject_name(good)) << good;
  for (const char* bad : {"", "a b", "cert:a", "https://x/a", "a\n", "ä"}) EXPECT_FALSE(is_subject_name(bad)) << bad;
  EXPECT_TRUE(is_subject_name(std::string(64, 'a')));
  EXPECT_FALSE(is_subject_name(std::string(65, 'a')));
}

}  // namespace
}  // namespace segserve::credentials
