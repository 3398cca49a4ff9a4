// SPDX-License-Identifier: Apache-2.0
#include "server/http/http_tls.hpp"

#include <string_view>
#include <utility>

#include "core/base/status_macros.hpp"
#include "fmt/format.h"
#include "openssl/x509v3.h"
#include "tls/certificates.hpp"
#include "tls/openssl_error.hpp"

namespace segserve::server {
namespace {

absl::Status failure(std::string_view what) {
  return absl::InternalError(fmt::format("TLS: {}: {}", what, tls::take_openssl_error()));
}

/// Takes HTTP/1.1 of what the client offers, if it offers anything.
int choose_protocol(SSL* /*connection*/, const unsigned char** chosen, unsigned char* length,
                    const unsigned char* offered, unsigned int offered_length, void* /*unused*/) {
  static constexpr std::string_view kOurs = "\x08http/1.1";
  unsigned char* found = nullptr;
  const int result = SSL_select_next_proto(&found, length, reinterpret_cast<const unsigned char*>(kOurs.data()),
                                           static_cast<unsigned int>(kOurs.size()), offered, offered_length);
  *chosen = found;
  return result == OPENSSL_NPN_NEGOTIATED ? SSL_TLSEXT_ERR_OK : SSL_TLSEXT_ERR_ALERT_FATAL;
}

absl::Status ask_for_client(const std::string& authorities, SSL_CTX* context) {
  ASSIGN_OR_RETURN(const auto certificates, tls::parse_certificates(authorities));
  X509_STORE* const store = SSL_CTX_get_cert_store(context);
  for (const tls::X509Pointer& certificate : certificates) {
    if (X509_STORE_add_cert(store, certificate.get()) != 1 || SSL_CTX_add_client_CA(context, certificate.get()) != 1) {
      return failure("an authority cannot be used");
    }
  }
  SSL_CTX_set_verify(context, SSL_VERIFY_PEER | SSL_VERIFY_FAIL_IF_NO_PEER_CERT, nullptr);
  return absl::OkStatus();
}

absl::StatusOr<tls::SslContextPointer> make_context(const tls::TlsContents& contents) {
  tls::SslContextPointer context(SSL_CTX_new(TLS_server_method()));
  if (!context) return failure("there is no context");
  SSL_CTX_set_min_proto_version(context.get(), TLS1_2_VERSION);
  SSL_CTX_set_options(context.get(), SSL_OP_NO_RENEGOTIATION | SSL_OP_NO_COMPRESSION);
  SSL_CTX_set_session_cache_mode(context.get(), SSL_SESS_CACHE_OFF);
  SSL_CTX_set_mode(context.get(), SSL_MODE_RELEASE_BUFFERS);
  SSL_CTX_set_alpn_select_cb(context.get(), choose_protocol, nullptr);
  ASSIGN_OR_RETURN(const auto chain, tls::parse_certificates(contents.certificate));
  ASSIGN_OR_RETURN(const auto key, tls::parse_key(contents.key));
  if (SSL_CTX_use_certificate(context.get(), chain.front().get()) != 1 ||
      SSL_CTX_use_PrivateKey(context.get(), key.get()) != 1) {
    return failure("the certificate cannot be used");
  }
  for (std::size_t k = 1; k < chain.size(); ++k) {
    if (SSL_CTX_add1_chain_cert(context.get(), chain[k].get()) != 1) return failure("the chain cannot be used");
  }
  if (!contents.authorities.empty()) RETURN_IF_ERROR(ask_for_client(contents.authorities, context.get()));
  // The sessions of one server are of no other, and those of clients without a certificate of none.
  constexpr std::string_view kSessions = "segserve http";
  SSL_CTX_set_session_id_context(context.get(), reinterpret_cast<const unsigned char*>(kSessions.data()),
                                 static_cast<unsigned int>(kSessions.size()));
  return context;
}

/// The bytes of a string of ASN.1; empty if it holds a NUL, by which a name could be made to look like another one.
std::string text_of(const ASN1_STRING* string) {
  if (string == nullptr) return "";
  std::string text(reinterpret_cast<const char*>(ASN1_STRING_get0_data(string)),
                   static_cast<std::size_t>(ASN1_STRING_length(string)));
  return text.find('\0') == std::string::npos ? text : "";
}

std::string common_name(const X509& certificate) {
  const X509_NAME* const subject = X509_get_subject_name(&certificate);
  const int position = X509_NAME_get_index_by_NID(subject, NID_commonName, -1);
  if (position < 0) return "";
  return text_of(X509_NAME_ENTRY_get_data(X509_NAME_get_entry(subject, position)));
}

}  // namespace

absl::StatusOr<tls::SslContextPointer> HttpTls::context() {
  const auto current = certificates_->identity();
  const MutexLock lock(mutex_);
  if (identity_ != current) {
    ASSIGN_OR_RETURN(context_, make_context(current->contents));
    identity_ = current;
  }
  SSL_CTX_up_ref(context_.get());
  return tls::SslContextPointer(context_.get());
}

std::string certificate_name(const SSL& connection) {
  const tls::X509Pointer certificate(SSL_get1_peer_certificate(&connection));
  if (!certificate || SSL_get_verify_result(&connection) != X509_V_OK) return "";
  const tls::NamesPointer names(
      static_cast<GENERAL_NAMES*>(X509_get_ext_d2i(certificate.get(), NID_subject_alt_name, nullptr, nullptr)));
  for (const int kind : {GEN_URI, GEN_DNS}) {
    for (int k = 0; names && k < sk_GENERAL_NAME_num(names.get()); ++k) {
      const GENERAL_NAME* const name = sk_GENERAL_NAME_value(names.get(), k);
      if (name->type != kind) continue;
      std::string text = text_of(kind == GEN_URI ? name->d.uniformResourceIdentifier : name->d.dNSName);
      if (!text.empty()) return text;
    }
  }
  return common_name(*certificate);
}

}  // namespace segserve::server
