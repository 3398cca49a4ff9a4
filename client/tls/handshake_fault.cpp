// SPDX-License-Identifier: Apache-2.0
#include "client/tls/handshake_fault.hpp"

#include "absl/strings/cord.h"
#include "absl/strings/str_join.h"
#include "fmt/format.h"
#include "tls/certificates.hpp"

namespace segserve::client {
namespace {

using End = HandshakeReport::End;

constexpr const char* kPayload = "segserve.client/handshake_fault";

std::string untrusted(const HandshakeReport& report, const std::string& address, const tls::TlsFiles& files) {
  return fmt::format("the certificate of {} ({}) was signed by {}, which none of the authorities in {} confirms",
                     address, tls::text_of(X509_get_subject_name(report.server_certificate.get())),
                     tls::text_of(X509_get_issuer_name(report.server_certificate.get())), files.authorities);
}

/// Describes what is wrong with the certificates of the server.
std::string server_fault(const HandshakeReport& report, const std::string& address, const HostAndPort& server,
                         const ClientTls& tls) {
  const X509& wrong = report.wrong_certificate ? *report.wrong_certificate : *report.server_certificate;
  const tls::Validity validity = tls::validity_of(wrong);
  switch (report.verify_error) {
    case X509_V_ERR_CERT_HAS_EXPIRED:
      return fmt::format("the certificate of {} ({}) ended on {}", address, tls::text_of(X509_get_subject_name(&wrong)),
                         tls::text_of(validity.end));
    case X509_V_ERR_CERT_NOT_YET_VALID:
      return fmt::format("the certificate of {} ({}) is not valid before {}; is the clock of this machine right?",
                         address, tls::text_of(X509_get_subject_name(&wrong)), tls::text_of(validity.begin));
    case X509_V_ERR_HOSTNAME_MISMATCH:
    case X509_V_ERR_IP_ADDRESS_MISMATCH:
      return fmt::format(
          "the certificate of {} is for {}, and not for {}; connect by one of its names, or say which one to expect "
          "(segctl: --tls-server-name)",
          address, absl::StrJoin(tls::names_of(*report.server_certificate), ", "),
          tls.server_name.empty() ? server.host : tls.server_name);
    case X509_V_ERR_UNABLE_TO_GET_ISSUER_CERT:
    case X509_V_ERR_UNABLE_TO_GET_ISSUER_CERT_LOCALLY:
    case X509_V_ERR_UNABLE_TO_VERIFY_LEAF_SIGNATURE:
    case X509_V_ERR_DEPTH_ZERO_SELF_SIGNED_CERT:
    case X509_V_ERR_SELF_SIGNED_CERT_IN_CHAIN:
    case X509_V_ERR_CERT_SIGNATURE_FAILURE:
      return untrusted(report, address, tls.files);
    default:
      return fmt::format("the certificate of {} ({}) is not accepted: {}", address,
                         tls::text_of(X509_get_subject_name(&wrong)),
                         X509_verify_cert_error_string(report.verify_error));
  }
}

/// Why the server refused a client that showed its certificate, as far as the client can tell.
std::string why_refused(const HandshakeReport& report, const ClientTls& tls,
                        std::chrono::system_clock::time_point now) {
  const tls::Validity& validity = *tls.identity->validity.certificate;
  if (now >= validity.end) return fmt::format("it ended on {}", tls::text_of(validity.end));
  if (now < validity.begin) return fmt::format("it is not valid before {}", tls::text_of(validity.begin));
  const auto chain = tls::parse_certificates(tls.identity->contents.certificate);
  const std::string issuer = chain.ok() ? tls::text_of(X509_get_issuer_name(chain->back().get())) : "";
  if (!report.client_authorities.empty()) {
    return fmt::format("it was signed by {}, and the server trusts {}", issuer,
                       absl::StrJoin(report.client_authorities, " and "));
  }
  return report.error.empty() ? "the server does not say why" : "the server says: " + report.error;
}

std::string client_fault(const HandshakeReport& report, const std::string& address, const ClientTls& tls,
                         std::chrono::system_clock::time_point now) {
  if (tls.files.certificate.empty()) {
    return fmt::format("{} asks for a client certificate, and this client has none (segctl: --tls-cert and --tls-key)",
                       address);
  }
  return fmt::format("{} refused the client certificate of {}: {}", address, tls.files.certificate,
                     why_refused(report, tls, now));
}

/// Empty if nothing is found.
std::string message_about(const HandshakeReport& report, const std::string& address, const HostAndPort& server,
                          const std::optional<ClientTls>& tls, std::chrono::system_clock::time_point now) {
  if (!tls) {
    if (!report.server_certificate) return "";
    return fmt::format("{} speaks TLS, and this client plain text (segctl: --tls or --tls-ca)", address);
  }
  if (report.end == End::kNotTls) {
    return fmt::format(
        "{} speaks no TLS, and this client nothing else (segctl: leave out --tls, --tls-ca and their kin)", address);
  }
  if (report.server_certificate && report.verify_error != X509_V_OK) return server_fault(report, address, server, *tls);
  const bool was_refused = report.end == End::kFailed || report.end == End::kClosed;
  if (was_refused && report.wants_client_certificate) return client_fault(report, address, *tls, now);
  if (report.end == End::kFailed) {
    return fmt::format("the TLS handshake with {} failed: {}", address, report.error);
  }
  if (report.end == End::kGreeted && !report.speaks_http2) {
    return fmt::format("{} speaks TLS, but not HTTP/2 (ALPN h2) over it; is segserve running there?", address);
  }
  return "";
}

}  // namespace

absl::Status fault_of(const HandshakeReport& report, const std::string& address, const HostAndPort& server,
                      const std::optional<ClientTls>& tls, std::chrono::system_clock::time_point now) {
  const std::string message = message_about(report, address, server, tls, now);
  if (message.empty()) return absl::OkStatus();
  absl::Status fault = absl::UnauthenticatedError(message);
  fault.SetPayload(kPayload, absl::Cord());
  return fault;
}

absl::Status find_handshake_fault(const std::string& address, const std::optional<ClientTls>& tls,
                                  std::chrono::milliseconds timeout) {
  const std::optional<HostAndPort> server = host_and_port(address);
  if (!server) return absl::OkStatus();
  return fault_of(probe_handshake(*server, tls, timeout), address, *server, tls, std::chrono::system_clock::now());
}

bool is_handshake_fault(const absl::Status& status) { return status.GetPayload(kPayload).has_value(); }

}  // namespace segserve::client
