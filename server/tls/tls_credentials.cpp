// SPDX-License-Identifier: Apache-2.0
#include "server/tls/tls_credentials.hpp"

#include <string>
#include <utility>

#include "grpc/grpc.h"
#include "grpc/grpc_security.h"

namespace segserve::server {
namespace {

class TlsCredentials final : public grpc::ServerCredentials {
 public:
  explicit TlsCredentials(std::shared_ptr<const CertificateReloader> certificates)
      : certificates_(std::move(certificates)) {}

  /// Is never called: the handlers of calls check tokens themselves.
  void SetAuthMetadataProcessor(const std::shared_ptr<grpc::AuthMetadataProcessor>& /*processor*/) override {}

 private:
  int AddPortToServer(const std::string& address, grpc_server* server) override {
    const bool wants_client = certificates_->status().client_ca_end.has_value();
    grpc_ssl_server_credentials_options* options = grpc_ssl_server_credentials_create_options_using_config_fetcher(
        wants_client ? GRPC_SSL_REQUEST_AND_REQUIRE_CLIENT_CERTIFICATE_AND_VERIFY
                     : GRPC_SSL_DONT_REQUEST_CLIENT_CERTIFICATE,
        fetch, this);
    grpc_server_credentials* credentials = grpc_ssl_server_credentials_create_with_options(options);
    const int port = grpc_server_add_http2_port(server, address.c_str(), credentials);
    grpc_server_credentials_release(credentials);
    return port;
  }

  /// gRPC calls this before each handshake, under a lock of the port.
  static grpc_ssl_certificate_config_reload_status fetch(void* self, grpc_ssl_server_certificate_config** config) {
    return static_cast<TlsCredentials*>(self)->fetch(config);
  }

  grpc_ssl_certificate_config_reload_status fetch(grpc_ssl_server_certificate_config** config) {
    auto identity = certificates_->identity();
    if (identity == served_) return GRPC_SSL_CERTIFICATE_CONFIG_RELOAD_UNCHANGED;
    served_ = std::move(identity);
    const tls::TlsContents& contents = served_->contents;
    const grpc_ssl_pem_key_cert_pair pair{.private_key = contents.key.c_str(),
                                          .cert_chain = contents.certificate.c_str()};
    // gRPC 1.51 aborts without authorities, even if it asks no client for a certificate and so never uses them.
    const std::string& authorities = contents.authorities.empty() ? contents.certificate : contents.authorities;
    *config = grpc_ssl_server_certificate_config_create(authorities.c_str(), &pair, 1);
    return GRPC_SSL_CERTIFICATE_CONFIG_RELOAD_NEW;
  }

  const std::shared_ptr<const CertificateReloader> certificates_;
  std::shared_ptr<const tls::TlsIdentity> served_;  // the set that gRPC has
};

}  // namespace

std::shared_ptr<grpc::ServerCredentials> tls_credentials(std::shared_ptr<const CertificateReloader> certificates) {
  return std::make_shared<TlsCredentials>(std::move(certificates));
}

}  // namespace segserve::server
