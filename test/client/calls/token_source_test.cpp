// SPDX-License-Identifier: Apache-2.0
#include "client/calls/token_source.hpp"

#include <filesystem>
#include <fstream>
#include <string>

#include "gmock/gmock.h"
#include "test/temporary_path.hpp"

namespace segserve::client {
namespace {

class TokenSourceTest : public testing::Test {
 protected:
  ~TokenSourceTest() override { std::filesystem::remove(path_); }

  void write(const std::string& content) const { std::ofstream(path_) << content; }

  const std::string path_ = test::temporary_path("token");
};

TEST_F(TokenSourceTest, HasTheTokenOfTheOptions) {
  EXPECT_EQ((*TokenSource::make({}))->token(), "");
  EXPECT_EQ((*TokenSource::make({.token = "segserve_a-b"}))->token(), "segserve_a-b");
}

TEST_F(TokenSourceTest, ReadsItsFileAnew) {
  write("one\n");
  const auto source = TokenSource::make({.token_file = path_});
  ASSERT_TRUE(source.ok()) << source.status();
  EXPECT_EQ((*source)->token(), "one");
  write(" two \r\n");
  EXPECT_EQ((*source)->token(), "two");
  write("");
  EXPECT_EQ((*source)->token(), "two") << "the file is being written";
  std::filesystem::remove(path_);
  EXPECT_EQ((*source)->token(), "two");
}

TEST_F(TokenSourceTest, RefusesWhatIsNoTokenWithoutTellingIt) {
  for (const char* text : {"two words", "secret\nsecret2",
                           "s\xc3\xa9"
                           "cret",
                           "secret\"", "sec\trret"}) {
    write(text);
    for (const auto& source : {TokenSource::make({.token_file = path_}), TokenSource::make({.token = text})}) {
      EXPECT_TRUE(absl::IsInvalidArgument(source.status())) << text;
      EXPECT_THAT(std::string(source.status().message()), testing::Not(testing::HasSubstr("sec"))) << text;
    }
  }
  write(std::string(20'000, 'a'));
  EXPECT_TRUE(absl::IsInvalidArgument(TokenSource::make({.token_file = path_}).status()));
  EXPECT_TRUE(absl::IsInvalidArgument(TokenSource::make({.token = "a", .token_file = path_}).status()));
  EXPECT_TRUE(absl::IsNotFound(TokenSource::make({.token_file = path_ + "-none"}).status()));
  write("");
  EXPECT_TRUE(absl::IsNotFound(TokenSource::make({.token_file = path_}).status()));
}

TEST(PlainTextToken, StaysOnThisMachine) {
  for (const char* near : {"127.0.0.1:50051", "127.1.2.3:1", "localhost:50051", "[::1]:50051", "unix:/run/s.sock",
                           "unix-abstract:s", "ipv4:127.0.0.1:5", "ipv6:[::1]:5"}) {
    EXPECT_TRUE(check_plain_text_token(near).ok()) << near;
  }
  for (const char* far :
       {"robot:50051", "10.0.0.1:50051", "127.example.com:50051", "localhost.example.com:50051", "[2001:db8::1]:50051",
        "dns:///localhost:50051", "ipv4:10.0.0.1:5", "127.0.0.1.example.com:5"}) {
    EXPECT_TRUE(absl::IsInvalidArgument(check_plain_text_token(far))) << far;
  }
}

TEST(PlainTextToken, IsNotSentByAClientUnlessToldSo) {
  EXPECT_TRUE(absl::IsInvalidArgument(Client::connect({.address = "127.0.0.1:1,robot:1", .token = "a"}).status()));
  EXPECT_TRUE(Client::connect({.address = "robot:1", .token = "a", .insecure_token = true}).ok());
  EXPECT_TRUE(Client::connect({.address = "robot:1"}).ok());
}

}  // namespace
}  // namespace segserve::client
