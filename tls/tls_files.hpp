// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>

#include "absl/status/statusor.h"
#include "tls/certificates.hpp"

namespace segserve::tls {

/// The paths of the files by which one end of a TLS connection proves who it is, and knows whom it trusts. All are in
/// PEM. An empty path stands for no file.
struct TlsFiles {
  std::string certificate;  ///< the certificate, and the chain to its authority after it
  std::string key;          ///< the private key of the certificate, not encrypted
  std::string authorities;  ///< the certificates of those who may sign the other end's certificate
};

/// The contents of the files.
struct TlsContents {
  std::string certificate;
  std::string key;
  std::string authorities;

  friend bool operator==(const TlsContents&, const TlsContents&) = default;
};

/// When the certificates are valid: all of the chain, and all authorities. Unset where there is no file.
struct TlsValidity {
  std::optional<Validity> certificate;
  std::optional<Validity> authorities;
};

/// Reads the files. INVALID_ARGUMENT names the one that cannot be read, or is larger than 4 MiB.
absl::StatusOr<TlsContents> read_files(const TlsFiles& files);

/// Checks that all certificates and the key can be read, and that the key belongs to the certificate. INVALID_ARGUMENT
/// names the file and its fault. `files` serves messages only.
absl::StatusOr<TlsValidity> check_contents(const TlsFiles& files, const TlsContents& contents);

}  // namespace segserve::tls
