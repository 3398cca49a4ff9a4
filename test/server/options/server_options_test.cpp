// SPDX-License-Identifier: Apache-2.0
#include <string>
#include <vector>

#include "gmock/gmock.h"
#include "server/server.hpp"

namespace segserve::server {
namespace {

std::vector<std::string> wrong_flags(const ServerOptions& options) {
  std::vector<std::string> flags;
  for (const FieldViolation& fault : violations(options)) flags.push_back(fault.field);
  return flags;
}

TEST(ServerOptions, DefaultsAreValid) { EXPECT_THAT(wrong_flags({}), testing::IsEmpty()); }

TEST(ServerOptions, EveryFaultIsNamedAtOnce) {
  ServerOptions options;
  options.listen = "nowhere";
  options.threads = 0;
  options.queue = 0;
  options.queue_bytes = options.max_decoded_bytes - 1;
  options.queue_points = 99;
  options.max_points = 100;
  options.grace_period = std::chrono::milliseconds(-1);
  options.drain_delay = std::chrono::milliseconds(-1);
  options.defaults.lambda = 3;
  EXPECT_THAT(wrong_flags(options),
              testing::UnorderedElementsAre("listen", "threads", "queue", "queue-bytes", "queue-points", "grace-period",
                                            "drain-delay", "lambda"));
  const auto server = Server::start(options);
  EXPECT_EQ(server.status().code(), absl::StatusCode::kInvalidArgument);
  EXPECT_THAT(std::string(server.status().message()),
              testing::AllOf(testing::HasSubstr("listen"), testing::HasSubstr("queue")));
}

TEST(ServerOptions, PlainTextBeyondLoopbackMustBeAllowed) {
  ServerOptions options;
  options.listen = "0.0.0.0:0";
  EXPECT_THAT(wrong_flags(options), testing::ElementsAre("listen"));
  options.insecure_beyond_loopback = true;
  EXPECT_THAT(wrong_flags(options), testing::IsEmpty());
}

}  // namespace
}  // namespace segserve::server
