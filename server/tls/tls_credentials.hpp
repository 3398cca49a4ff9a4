// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>

#include "grpcpp/security/server_credentials.h"
#include "server/tls/certificate_reloader.hpp"

namespace segserve::server {

/// Credentials with which a gRPC server speaks TLS. Each new connection uses the certificates that `certificates` has
/// then; those that exist go on. If there are authorities for clients, a client must show a certificate of theirs.
///
/// They work for one port, and must outlive its server. gRPC 1.51 has credentials that read files again, but these
/// would take a key that does not belong to its certificate.
std::shared_ptr<grpc::ServerCredentials> tls_credentials(std::shared_ptr<const CertificateReloader> certificates);

}  // namespace segserve::server
