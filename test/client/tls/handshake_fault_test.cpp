// SPDX-License-Identifier: Apache-2.0
#include "client/tls/handshake_fault.hpp"

#include <chrono>
#include <optional>
#include <string>
#include <utility>

#include "client/tls/handshake_probe.hpp"
#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "test/tls/test_certificates.hpp"

namespace segserve::client {
namespace {

using std::chrono::hours;
using tls::make_identity;
using End = HandshakeReport::End;

class HandshakeFault : public testing::Test {
 protected:
  /// The message about a handshake with "robot:1"; empty if nothing is wrong.
  static std::string about(const HandshakeReport& report, const std::optional<ClientTls>& tls) {
    const absl::Status fault = fault_of(report, "robot:1", {"robot", "1"}, tls, std::chrono::system_clock::now());
    EXPECT_EQ(fault.code(), fault.ok() ? absl::StatusCode::kOk : absl::StatusCode::kUnauthenticated);
    EXPECT_EQ(is_handshake_fault(fault), !fault.ok());
    return std::string(fault.message());
  }

  /// A handshake in which the server has shown a certificate that has this fault.
  HandshakeReport report(End end, int verify_error = X509_V_OK) const {
    HandshakeReport report{.end = end};
    report.server_certificate = make_identity("server", &authority_).certificate;
    report.verify_error = verify_error;
    report.speaks_http2 = true;
    return report;
  }

  /// A client that shows a certificate that ends after this time.
  ClientTls client(std::chrono::seconds lifetime = hours(1)) const {
    const tls::TestIdentity own = make_identity("client", &authority_, lifetime);
    return client_with({.certificate = tls::write_test_file("client.crt", own.certificate_pem()),
                        .key = tls::write_test_file("client.key", own.key_pem()),
                        .authorities = tls::write_test_file("ca.crt", authority_.certificate_pem())});
  }
  /// A client that has no certificate.
  ClientTls anonymous() const {
    return client_with(
        {.certificate = "", .key = "", .authorities = tls::write_test_file("ca.crt", authority_.certificate_pem())});
  }

 private:
  static ClientTls client_with(const tls::TlsFiles& files) {
    return {.files = files, .identity = tls::TlsReload::load(files).value().identity(), .server_name = ""};
  }

  const tls::TestIdentity authority_ = make_identity("authority");
};

TEST_F(HandshakeFault, IsNoneIfTheServerGreetsOrIsSilent) {
  EXPECT_EQ(about(report(End::kGreeted), client()), "");
  EXPECT_EQ(about({.end = End::kUnknown}, client()), "");
  EXPECT_EQ(about({.end = End::kNotTls}, std::nullopt), "");
  EXPECT_EQ(about(report(End::kClosed), anonymous()), "") << "it may have died just then";
}

TEST_F(HandshakeFault, TellsWhichEndSpeaksTls) {
  EXPECT_EQ(about(report(End::kGreeted), std::nullopt),
            "robot:1 speaks TLS, and this client plain text (segctl: --tls or --tls-ca)");
  EXPECT_EQ(about({.end = End::kNotTls}, client()),
            "robot:1 speaks no TLS, and this client nothing else (segctl: leave out --tls, --tls-ca and their kin)");
  HandshakeReport web = report(End::kGreeted);
  web.speaks_http2 = false;
  EXPECT_THAT(about(web, client()), testing::HasSubstr("speaks TLS, but not HTTP/2"));
}

TEST_F(HandshakeFault, TellsWhatIsWrongWithTheServersCertificate) {
  const ClientTls tls = client();
  EXPECT_EQ(about(report(End::kGreeted, X509_V_ERR_UNABLE_TO_GET_ISSUER_CERT_LOCALLY), tls),
            "the certificate of robot:1 (CN=server) was signed by CN=authority, which none of the authorities in " +
                tls.files.authorities + " confirms");
  EXPECT_THAT(about(report(End::kGreeted, X509_V_ERR_HOSTNAME_MISMATCH), tls),
              testing::StartsWith("the certificate of robot:1 is for localhost, 127.0.0.1, and not for robot; "));
  ClientTls renamed = tls;
  renamed.server_name = "other";
  EXPECT_THAT(about(report(End::kGreeted, X509_V_ERR_HOSTNAME_MISMATCH), renamed),
              testing::HasSubstr("not for other;"));
  EXPECT_THAT(about(report(End::kGreeted, X509_V_ERR_CERT_HAS_EXPIRED), tls),
              testing::StartsWith("the certificate of robot:1 (CN=server) ended on 20"));
  EXPECT_THAT(about(report(End::kGreeted, X509_V_ERR_CERT_NOT_YET_VALID), tls),
              testing::HasSubstr("is the clock of this machine right?"));
  EXPECT_THAT(about(report(End::kGreeted, X509_V_ERR_CERT_REVOKED), tls),
              testing::HasSubstr("(CN=server) is not accepted: certificate revoked"));
}

TEST_F(HandshakeFault, TellsWhyTheServerRefusesTheClient) {
  HandshakeReport refusal = report(End::kClosed);
  refusal.wants_client_certificate = true;
  EXPECT_EQ(about(refusal, anonymous()),
            "robot:1 asks for a client certificate, and this client has none (segctl: --tls-cert and --tls-key)");
  const std::string refused = "robot:1 refused the client certificate of " + client().files.certificate + ": ";
  EXPECT_EQ(about(refusal, client()), refused + "the server does not say why");
  EXPECT_THAT(about(refusal, client(-hours(1))), testing::StartsWith(refused + "it ended on 20"));
  refusal.client_authorities = {"CN=one", "CN=two"};
  EXPECT_EQ(about(refusal, client()),
            refused + "it was signed by CN=authority, and the server trusts CN=one and CN=two");
  refusal.client_authorities.clear();
  refusal.end = End::kFailed;
  refusal.error = "tlsv1 alert unknown ca";
  EXPECT_EQ(about(refusal, client()), refused + "the server says: tlsv1 alert unknown ca");
  refusal.wants_client_certificate = false;
  EXPECT_EQ(about(refusal, client()), "the TLS handshake with robot:1 failed: tlsv1 alert unknown ca");
}

TEST(HostAndPort, IsThatOfTheFirstAddress) {
  const auto found = [](const std::string& address) {
    const auto server = host_and_port(address);
    return server ? server->host + " " + server->port : "none";
  };
  EXPECT_EQ(found("robot:50051"), "robot 50051");
  EXPECT_EQ(found("[::1]:7"), "::1 7");
  EXPECT_EQ(found("dns:robot:7"), "robot 7");
  EXPECT_EQ(found("dns:///robot:7"), "robot 7");
  EXPECT_EQ(found("dns://8.8.8.8/robot:7"), "robot 7");
  EXPECT_EQ(found("ipv4:10.0.0.1:7,10.0.0.2:8"), "10.0.0.1 7");
  EXPECT_EQ(found("ipv6:[::1]:7"), "::1 7");
  for (const char* none : {"unix:/run/s", "unix-abstract:s", "xds:///s", "dns:///robot", "[::1]", "", ":7", "//"}) {
    EXPECT_EQ(found(none), "none") << none;
  }
}

}  // namespace
}  // namespace segserve::client
