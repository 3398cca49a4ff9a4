// SPDX-License-Identifier: Apache-2.0
#include "client/stream/address_book.hpp"

#include "gmock/gmock.h"
#include "gtest/gtest.h"

namespace segserve::client {
namespace {

using std::chrono::milliseconds;
using testing::ElementsAre;

TEST(Addresses, AreSeparatedByCommas) {
  EXPECT_THAT(*parse_addresses("a:1"), ElementsAre("a:1"));
  EXPECT_THAT(*parse_addresses(" a:1, dns:///b:2 ,unix:/c"), ElementsAre("a:1", "dns:///b:2", "unix:/c"));
  for (const char* wrong : {"", " ", ",", "a:1,", "a:1,,b:2"}) {
    EXPECT_TRUE(absl::IsInvalidArgument(parse_addresses(wrong).status())) << wrong;
  }
}

TEST(Addresses, WithoutAPortHaveTheDefaultOne) {
  EXPECT_THAT(*parse_addresses("robot,10.0.0.7,[::1],fe80::1"),
              ElementsAre("robot:50051", "10.0.0.7:50051", "[::1]:50051", "[fe80::1]:50051"));
  EXPECT_THAT(*parse_addresses("[::1]:7"), ElementsAre("[::1]:7"));
}

TEST(Addresses, UrlsAndPortsThatAreNoneAreRefused) {
  for (const char* wrong : {"http://robot:50051", "grpc://robot", "robot:50051/v1", "robot:", "robot:port", "robot:0",
                            "robot:65536", "robot:-1"}) {
    const absl::Status status = parse_addresses(wrong).status();
    EXPECT_TRUE(absl::IsInvalidArgument(status)) << wrong;
    EXPECT_NE(status.message().find(wrong), std::string::npos) << status;
  }
}

TEST(Backoff, DoublesUpToALimitWithJitterAndObeysTheServer) {
  const RetryOptions retry{.first_backoff = milliseconds(100), .max_backoff = milliseconds(1000)};
  std::minstd_rand random(3);
  for (int i = 0; i < 100; ++i) {
    EXPECT_GE(backoff(retry, 1, {}, random), milliseconds(50));
    EXPECT_LE(backoff(retry, 1, {}, random), milliseconds(100));
    EXPECT_GE(backoff(retry, 3, {}, random), milliseconds(200));
    EXPECT_LE(backoff(retry, 3, {}, random), milliseconds(400));
    EXPECT_LE(backoff(retry, 1000, {}, random), milliseconds(1000));
    EXPECT_EQ(backoff(retry, 1, milliseconds(5000), random), milliseconds(5000));
  }
}

TEST(AddressBook, GoesOnToTheNextAndComesBackLater) {
  const Time now{std::chrono::hours(1)};
  AddressBook book(2, 5, RetryOptions{}, 1);
  EXPECT_EQ(book.choose(now).address, 1U);
  EXPECT_EQ(book.choose(now).not_before, now);
  book.failed(1, now, {});
  EXPECT_EQ(book.choose(now).address, 0U);
  EXPECT_FALSE(book.nobody_in_reach());
  book.failed(0, now, milliseconds(900));
  EXPECT_TRUE(book.nobody_in_reach());
  EXPECT_EQ(book.choose(now).address, 1U);
  EXPECT_GT(book.choose(now).not_before, now);
  EXPECT_EQ(book.choose(now + milliseconds(901)).not_before, now + milliseconds(901));
  book.reached(0);
  EXPECT_FALSE(book.nobody_in_reach());
  EXPECT_EQ(book.choose(now).address, 0U);
}

}  // namespace
}  // namespace segserve::client
