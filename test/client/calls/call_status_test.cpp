// SPDX-License-Identifier: Apache-2.0
#include "client/calls/call_status.hpp"

#include <string>

#include "gtest/gtest.h"

namespace segserve::client {
namespace {

std::string message(grpc::StatusCode code, const std::string& said) {
  return std::string(call_status(grpc::Status(code, said), "robot:50051").message());
}

TEST(CallStatus, TellsWhyThereIsNoConnection) {
  const std::string end = "; is segserve running there?";
  EXPECT_EQ(message(grpc::StatusCode::UNAVAILABLE,
                    "connections to all backends failing; last error: UNKNOWN: ipv4:127.0.0.1:1: Failed to connect to "
                    "remote host: Connection refused"),
            "no answer from robot:50051: Connection refused" + end);
  EXPECT_EQ(message(grpc::StatusCode::UNAVAILABLE,
                    "DNS resolution failed for robot:50051: C-ares status is not ARES_SUCCESS qtype=AAAA name=robot "
                    "is_balancer=0: Domain name not found"),
            "no answer from robot:50051: Domain name not found" + end);
  EXPECT_EQ(message(grpc::StatusCode::UNAVAILABLE, "Socket closed"), "no answer from robot:50051: Socket closed" + end);
}

TEST(CallStatus, AsksForNoServerIfOneMayBeSlow) {
  EXPECT_EQ(message(grpc::StatusCode::DEADLINE_EXCEEDED, "Deadline Exceeded"),
            "no answer from robot:50051: Deadline Exceeded");
  EXPECT_EQ(message(grpc::StatusCode::INVALID_ARGUMENT, "threshold: 7 is not in [0, 1]"),
            "threshold: 7 is not in [0, 1]");
}

}  // namespace
}  // namespace segserve::client
