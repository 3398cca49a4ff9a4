// SPDX-License-Identifier: Apache-2.0
// The client library against a real server with mutual TLS in this process.
#include <chrono>
#include <memory>
#include <string>
#include <thread>

#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "segserve/client/client.hpp"
#include "server/server.hpp"
#include "test/client/client_scenes.hpp"
#include "test/tls/test_certificates.hpp"

#ifdef __SANITIZE_ADDRESS__
/// LeakSanitizer asks the program for this. gRPC sometimes has failed handshakes left when a program ends. That our own
/// use of OpenSSL forgets nothing is checked by tls_test and server_parts_test, which run no gRPC.
extern "C" const char* __lsan_default_suppressions() {  // NOLINT(bugprone-reserved-identifier)
  return "leak:libcrypto.so\n";
}
#endif

namespace segserve::client {
namespace {

using std::chrono::milliseconds, std::chrono::seconds;
using testing::HasSubstr;
using tls::make_identity, tls::write_test_file;

class ClientOverTls : public testing::Test {
 protected:
  ClientOverTls() {
    const tls::TestIdentity own = make_identity("server", &authority_);
    server::ServerOptions options;
    options.listen = "127.0.0.1:0";
    options.workers = 1;
    options.drain_delay = milliseconds(0);
    options.tls_cert = write_test_file("server.crt", own.certificate_pem());
    options.tls_key = write_test_file("server.key", own.key_pem());
    options.tls_client_ca = authority_file_;
    server_ = server::Server::start(options).value();
    options_ = {.address = server_->address(), .timeout = seconds(60)};
    options_.tls = {.ca_file = authority_file_};
  }

  /// The client shows this certificate.
  void show(const tls::TestIdentity& identity) {
    options_.tls->cert_file = write_test_file("client.crt", identity.certificate_pem());
    options_.tls->key_file = write_test_file("client.key", identity.key_pem());
  }

  const tls::TestIdentity authority_ = make_identity("authority"), stranger_ = make_identity("stranger");
  const std::string authority_file_ = write_test_file("ca.crt", authority_.certificate_pem());
  std::unique_ptr<server::Server> server_;
  ClientOptions options_;
};

TEST_F(ClientOverTls, SegmentsByCallsAndStreams) {
  show(make_identity("client", &authority_));
  const auto client = Client::connect(options_);
  ASSERT_TRUE(client.ok()) << client.status();
  EXPECT_TRUE(client->health().ok()) << client->health();
  EXPECT_TRUE(client->segment(flat_cloud(20, 20)).ok());
  auto stream = client->open_stream();
  ASSERT_TRUE(stream->send(flat_cloud(20, 20)).ok());
  EXPECT_EQ(stream->next()->kind, OutcomeKind::kResult);
}

TEST_F(ClientOverTls, AWrongCertificateEndsCallsAndStreamsLongBeforeTheirDeadline) {
  options_.wait_for_server = true;
  show(make_identity("client", &stranger_));
  const auto client = Client::connect(options_);
  const auto start = std::chrono::steady_clock::now();
  const absl::Status health = client->health();
  EXPECT_TRUE(absl::IsUnauthenticated(health)) << health;
  EXPECT_THAT(std::string(health.message()),
              HasSubstr("it was signed by CN=stranger, and the server trusts CN=authority"));
  auto stream = client->open_stream({.frame_timeout = seconds(60)});
  ASSERT_TRUE(stream->send(flat_cloud(20, 20)).ok());
  const auto outcome = stream->next();
  EXPECT_EQ(outcome->kind, OutcomeKind::kFailed);
  EXPECT_TRUE(absl::IsUnauthenticated(outcome->status)) << outcome->status;
  EXPECT_TRUE(absl::IsUnauthenticated(stream->send(flat_cloud(20, 20)).status())) << "the stream is over";
  EXPECT_LT(std::chrono::steady_clock::now() - start, seconds(30));
}

TEST_F(ClientOverTls, AStreamThatClosesDuringAFailingHandshakeDoesNoHarm) {
  show(make_identity("client", &stranger_));
  const auto client = Client::connect(options_);
  for (int i = 0; i < 10; ++i) {
    auto stream = client->open_stream();
    ASSERT_TRUE(stream->send(flat_cloud(20, 20)).ok());
    std::this_thread::sleep_for(milliseconds(2 * i));
  }
}

TEST_F(ClientOverTls, ARenewedClientCertificateIsUsedFromTheNextCallOn) {
  show(make_identity("client", &stranger_));
  const auto client = Client::connect(options_);
  EXPECT_TRUE(absl::IsUnauthenticated(client->health()));
  show(make_identity("client", &authority_));
  std::this_thread::sleep_for(milliseconds(1100));
  EXPECT_TRUE(client->health().ok());
  show(make_identity("client", &stranger_));
  write_test_file("client.key", "no key");
  std::this_thread::sleep_for(milliseconds(1100));
  EXPECT_TRUE(client->health().ok()) << "files that are wrong are not used";
}

TEST_F(ClientOverTls, FilesAndOptionsThatAreWrongAreToldAtOnce) {
  const auto fault = [this](auto change) {
    ClientOptions changed = options_;
    change(changed);
    const absl::Status status = Client::connect(changed).status();
    EXPECT_TRUE(absl::IsInvalidArgument(status)) << status;
    return std::string(status.message());
  };
  EXPECT_THAT(fault([](ClientOptions& options) { options.tls->ca_file = "/no/such"; }),
              HasSubstr("cannot read /no/such"));
  EXPECT_THAT(fault([](ClientOptions& options) { options.tls->key_file = "k"; }), HasSubstr("has no certificate file"));
  EXPECT_THAT(fault([](ClientOptions& options) { options.tls->cert_file = "c"; }), HasSubstr("has no key file"));
  EXPECT_THAT(fault([](ClientOptions& options) { options.address = "a:1,unix:/run/s"; }),
              HasSubstr("unix:/run/s is a unix socket, which has no TLS"));
}

TEST_F(ClientOverTls, TheServerTellsWhenItsCertificatesEnd) {
  const auto status = server_->tls_status();
  ASSERT_TRUE(status);
  const auto now = std::chrono::system_clock::now();
  EXPECT_GT(status->certificate_end, now);
  EXPECT_LE(status->certificate_end, now + std::chrono::hours(1));
  EXPECT_TRUE(status->client_ca_end);
  EXPECT_EQ(status->reloads + status->failed_reloads, 0U);
}

}  // namespace
}  // namespace segserve::client
