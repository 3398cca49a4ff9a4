// SPDX-License-Identifier: Apache-2.0
#include <string>
#include <utility>
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
  options.insecure_beyond_loopback = false;
  options.tls_cert = options.tls_key = "a file";
  EXPECT_THAT(wrong_flags(options), testing::IsEmpty());
}

TEST(ServerOptions, TlsNeedsACertificateAndItsKey) {
  ServerOptions options;
  options.tls_cert = "a file";
  EXPECT_THAT(wrong_flags(options), testing::ElementsAre("tls-cert"));
  std::swap(options.tls_cert, options.tls_key);
  EXPECT_THAT(wrong_flags(options), testing::ElementsAre("tls-key"));
  options.tls_key.clear();
  options.tls_client_ca = "a file";
  EXPECT_THAT(wrong_flags(options), testing::ElementsAre("tls-client-ca"));
}

TEST(ServerOptions, EachServerHasAnAddressOfItsOwn) {
  ServerOptions options;
  options.listen = options.health_listen = options.metrics_listen = "127.0.0.1:0";
  EXPECT_THAT(wrong_flags(options), testing::IsEmpty()) << "port 0 is another one each time";
  options.listen = options.metrics_listen = "127.0.0.1:50051";
  EXPECT_THAT(wrong_flags(options), testing::ElementsAre("metrics-listen"));
  options.health_listen = "127.0.0.1:50051";
  EXPECT_THAT(wrong_flags(options), testing::ElementsAre("health-listen", "metrics-listen", "metrics-listen"));
}

TEST(ServerOptions, AUnixSocketHasNoTls) {
  ServerOptions options;
  options.listen = "unix:/tmp/socket";
  options.tls_cert = options.tls_key = "a file";
  EXPECT_THAT(wrong_flags(options), testing::ElementsAre("tls-cert"));
}

TEST(ServerOptions, TokensInPlainTextBeyondLoopbackMustBeAllowed) {
  ServerOptions options;
  options.tokens = "tokens.toml";
  EXPECT_THAT(wrong_flags(options), testing::IsEmpty());
  options.listen = "0.0.0.0:0";
  options.insecure_beyond_loopback = true;
  EXPECT_THAT(wrong_flags(options), testing::ElementsAre("tokens"));
  options.insecure_tokens = true;
  EXPECT_THAT(wrong_flags(options), testing::IsEmpty());
}

TEST(ServerOptions, JsonWebTokensNeedTheirIssuerAndAudience) {
  ServerOptions options;
  options.jwt_keys = "keys.json";
  EXPECT_THAT(wrong_flags(options), testing::ElementsAre("jwt-issuer", "jwt-audience"));
  options.jwt_issuer = "https://idp.example";
  options.jwt_audience = "segserve";
  EXPECT_THAT(wrong_flags(options), testing::IsEmpty());
  options.jwt_keys = "";
  EXPECT_THAT(wrong_flags(options), testing::ElementsAre("jwt-issuer", "jwt-audience"));
}

}  // namespace
}  // namespace segserve::server
