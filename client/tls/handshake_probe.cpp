// SPDX-License-Identifier: Apache-2.0
#include "client/tls/handshake_probe.hpp"

#include <algorithm>
#include <array>
#include <string_view>
#include <utility>

#include "client/tls/timed_socket.hpp"
#include "openssl/err.h"
#include "openssl/ssl.h"
#include "tls/certificates.hpp"
#include "tls/openssl_error.hpp"

namespace segserve::client {
namespace {

using End = HandshakeReport::End;

// RFC 9113, section 3.4: the preface of a client, and its empty SETTINGS frame.
constexpr std::string_view kGreeting("PRI * HTTP/2.0\r\n\r\nSM\r\n\r\n\0\0\0\4\0\0\0\0\0", 33);
// RFC 7301: the list that holds the protocol "h2" alone.
constexpr std::array<unsigned char, 3> kHttp2{2, 'h', '2'};

/// Notes the first fault of the server's certificates, and lets the handshake go on.
int note_fault(int is_right, X509_STORE_CTX* verification) {
  const auto* ssl =
      static_cast<const SSL*>(X509_STORE_CTX_get_ex_data(verification, SSL_get_ex_data_X509_STORE_CTX_idx()));
  auto& report = *static_cast<HandshakeReport*>(SSL_get_app_data(ssl));
  if (is_right == 0 && report.verify_error == X509_V_OK) {
    report.verify_error = X509_STORE_CTX_get_error(verification);
    X509* wrong = X509_STORE_CTX_get_current_cert(verification);
    if (wrong != nullptr && X509_up_ref(wrong) == 1) report.wrong_certificate.reset(wrong);
  }
  return 1;
}

/// Notes that the server asks for a client certificate.
int note_request(SSL* ssl, void* /*unused*/) {
  auto& report = *static_cast<HandshakeReport*>(SSL_get_app_data(ssl));
  report.wants_client_certificate = true;
  const STACK_OF(X509_NAME)* names = SSL_get0_peer_CA_list(ssl);
  constexpr int kMostNames = 5;
  for (int i = 0; i < std::min(sk_X509_NAME_num(names), kMostNames); ++i) {
    report.client_authorities.push_back(tls::text_of(sk_X509_NAME_value(names, i)));
  }
  return 1;
}

/// Loads what was checked when the files were read.
void load(SSL_CTX& context, const tls::TlsContents& contents) {
  X509_STORE* store = SSL_CTX_get_cert_store(&context);
  X509_STORE_set_flags(store, X509_V_FLAG_PARTIAL_CHAIN | X509_V_FLAG_TRUSTED_FIRST);  // as gRPC does
  if (const auto authorities = tls::parse_certificates(contents.authorities); authorities.ok()) {
    for (const auto& each : *authorities) X509_STORE_add_cert(store, each.get());
  }
  const auto chain = tls::parse_certificates(contents.certificate);
  const auto key = tls::parse_key(contents.key);
  if (!chain.ok() || !key.ok()) return;
  SSL_CTX_use_certificate(&context, chain->front().get());
  for (std::size_t i = 1; i < chain->size(); ++i) SSL_CTX_add1_chain_cert(&context, (*chain)[i].get());
  SSL_CTX_use_PrivateKey(&context, key->get());
}

tls::SslPointer make_ssl(const std::optional<ClientTls>& tls, const std::string& host, HandshakeReport& report) {
  const tls::SslContextPointer context(SSL_CTX_new(TLS_client_method()));
  SSL_CTX_set_min_proto_version(context.get(), TLS1_2_VERSION);
  SSL_CTX_set_alpn_protos(context.get(), kHttp2.data(), kHttp2.size());
  SSL_CTX_set_verify(context.get(), SSL_VERIFY_PEER, note_fault);
  SSL_CTX_set_cert_cb(context.get(), note_request, nullptr);
  if (tls) load(*context, tls->identity->contents);
  tls::SslPointer ssl(SSL_new(context.get()));
  SSL_set_app_data(ssl.get(), &report);
  SSL_set_bio(ssl.get(), BIO_new(BIO_s_mem()), BIO_new(BIO_s_mem()));
  SSL_set_connect_state(ssl.get());
  const std::string& name = tls && !tls->server_name.empty() ? tls->server_name : host;
  if (X509_VERIFY_PARAM_set1_ip_asc(SSL_get0_param(ssl.get()), name.c_str()) != 1) {
    SSL_set_tlsext_host_name(ssl.get(), name.c_str());
    SSL_set1_host(ssl.get(), name.c_str());
  }
  ERR_clear_error();
  return ssl;
}

bool send_pending(SSL& ssl, TimedSocket& socket) {
  char* bytes = nullptr;
  const long size = BIO_get_mem_data(SSL_get_wbio(&ssl), &bytes);
  const bool sent = size <= 0 || socket.send(std::string_view(bytes, static_cast<std::size_t>(size)));
  BIO_reset(SSL_get_wbio(&ssl));
  return sent;
}

/// Runs a function of OpenSSL again and again, and moves its bytes, until it has done its work. Otherwise returns how
/// the attempt ended; `at_close` stands for a connection that the server closed.
template <typename Step>
std::optional<End> finish(Step step, SSL& ssl, TimedSocket& socket, End at_close, std::string& error) {
  std::array<char, 16384> buffer{};
  while (true) {
    const int result = step(&ssl);
    const int kind = SSL_get_error(&ssl, result);
    send_pending(ssl, socket);  // if that fails, so does what follows
    if (result > 0) return std::nullopt;
    if (kind == SSL_ERROR_ZERO_RETURN) return at_close;
    if (kind != SSL_ERROR_WANT_READ) {
      const int reason = ERR_GET_REASON(ERR_peek_last_error());
      error = tls::take_openssl_error();
      return reason == SSL_R_WRONG_VERSION_NUMBER ? End::kNotTls : End::kFailed;
    }
    const std::optional<std::size_t> received = socket.receive(buffer);
    if (!received) return End::kUnknown;
    if (*received == 0) return at_close;
    BIO_write(SSL_get_rbio(&ssl), buffer.data(), static_cast<int>(*received));
  }
}

End shake_hands(SSL& ssl, TimedSocket& socket, HandshakeReport& report) {
  const auto failed = finish(SSL_do_handshake, ssl, socket, End::kUnknown, report.error);
  report.server_certificate.reset(SSL_get1_peer_certificate(&ssl));
  if (failed) return *failed;
  const unsigned char* protocol = nullptr;
  unsigned length = 0;
  SSL_get0_alpn_selected(&ssl, &protocol, &length);
  report.speaks_http2 = length > 0;
  SSL_write(&ssl, kGreeting.data(), static_cast<int>(kGreeting.size()));
  const auto read_byte = [](SSL* from) {
    char byte = 0;
    return SSL_read(from, &byte, 1);
  };
  return finish(read_byte, ssl, socket, End::kClosed, report.error).value_or(End::kGreeted);
}

}  // namespace

std::optional<HostAndPort> host_and_port(const std::string& address) {
  std::string_view rest = address;
  for (const std::string_view unknown : {"unix:", "unix-abstract:", "xds:"}) {
    if (rest.starts_with(unknown)) return std::nullopt;
  }
  for (const std::string_view scheme : {"dns:", "ipv4:", "ipv6:", "passthrough:"}) {
    if (rest.starts_with(scheme)) rest.remove_prefix(scheme.size());
  }
  if (rest.starts_with("//")) rest.remove_prefix(std::min(rest.find('/', 2), rest.size() - 1) + 1);
  rest = rest.substr(0, rest.find(','));
  const std::size_t colon = rest.rfind(':');
  if (colon == std::string_view::npos || colon == 0 || rest.ends_with(']')) return std::nullopt;
  std::string_view host = rest.substr(0, colon);
  if (host.starts_with('[') && host.ends_with(']')) host = host.substr(1, host.size() - 2);
  return HostAndPort{std::string(host), std::string(rest.substr(colon + 1))};
}

HandshakeReport probe_handshake(const HostAndPort& server, const std::optional<ClientTls>& tls,
                                std::chrono::milliseconds timeout) {
  HandshakeReport report;
  TimedSocket socket(timeout);
  if (!socket.connect(server.host, server.port)) return report;
  const tls::SslPointer ssl = make_ssl(tls, server.host, report);
  report.end = shake_hands(*ssl, socket, report);
  ERR_clear_error();
  return report;
}

}  // namespace segserve::client
