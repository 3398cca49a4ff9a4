// SPDX-License-Identifier: Apache-2.0
#include "client/tls/tls_source.hpp"

#include <array>
#include <cstdlib>
#include <filesystem>
#include <system_error>

#include "core/base/status_macros.hpp"

namespace segserve::client {
namespace {

absl::StatusOr<std::string> system_authorities() {
  // The places of Debian and its kin, of Fedora and its kin, and of Alpine.
  constexpr std::array kUsualFiles{"/etc/ssl/certs/ca-certificates.crt", "/etc/pki/tls/certs/ca-bundle.crt",
                                   "/etc/ssl/cert.pem"};
  const char* chosen = std::getenv("SSL_CERT_FILE");
  if (chosen != nullptr && *chosen != '\0') return chosen;
  for (const char* file : kUsualFiles) {
    std::error_code error;
    if (std::filesystem::exists(file, error)) return file;
  }
  return absl::InvalidArgumentError(
      "this system's authorities are in none of the usual files; install ca-certificates, or name a file of "
      "authorities");
}

/// The files of the options, with the system's authorities if they name none.
absl::StatusOr<tls::TlsFiles> files_of(const TlsOptions& options) {
  if (options.cert_file.empty() != options.key_file.empty()) {
    return absl::InvalidArgumentError(options.key_file.empty() ? "the client certificate has no key file"
                                                               : "the client's key has no certificate file");
  }
  tls::TlsFiles files{.certificate = options.cert_file, .key = options.key_file, .authorities = options.ca_file};
  if (files.authorities.empty()) {
    ASSIGN_OR_RETURN(files.authorities, system_authorities());
  }
  return files;
}

}  // namespace

absl::StatusOr<TlsSource> TlsSource::load(const TlsOptions& options) {
  ASSIGN_OR_RETURN(tls::TlsFiles files, files_of(options));
  ASSIGN_OR_RETURN(tls::TlsReload reload, tls::TlsReload::load(std::move(files)));
  return TlsSource(std::move(reload), options.server_name);
}

bool TlsSource::refresh(std::chrono::steady_clock::time_point now) {
  if (now < read_at_ + std::chrono::seconds(1)) return false;
  read_at_ = now;
  return reload_.poll() == absl::OkStatus();
}

ClientTls TlsSource::current() const {
  return {.files = reload_.files(), .identity = reload_.identity(), .server_name = server_name_};
}

}  // namespace segserve::client
