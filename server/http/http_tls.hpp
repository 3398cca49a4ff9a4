// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <string>

#include "absl/base/thread_annotations.h"
#include "absl/status/statusor.h"
#include "core/base/mutex.hpp"
#include "openssl/ssl.h"
#include "server/tls/certificate_reloader.hpp"
#include "tls/openssl_pointers.hpp"

namespace segserve::server {

/// The contexts of OpenSSL by which the web entrance speaks TLS, with the certificates of the server: TLS 1.2 or later,
/// HTTP/1.1 only, and a certificate of each client if the server has authorities for these. Thread-safe.
class HttpTls {
 public:
  explicit HttpTls(std::shared_ptr<const CertificateReloader> certificates) : certificates_(std::move(certificates)) {}

  /// The context of new connections, with the certificates that are in use now. INTERNAL if OpenSSL refuses them.
  absl::StatusOr<tls::SslContextPointer> context();

 private:
  const std::shared_ptr<const CertificateReloader> certificates_;
  Mutex mutex_;
  std::shared_ptr<const tls::TlsIdentity> identity_ ABSL_GUARDED_BY(mutex_);  // that `context_` has
  tls::SslContextPointer context_ ABSL_GUARDED_BY(mutex_);
};

/// The name of the certificate of the other end, which has been verified: its first URI, or else DNS name, or else
/// common name, as those of calls of gRPC. Empty if it has shown none.
std::string certificate_name(const SSL& connection);

}  // namespace segserve::server
