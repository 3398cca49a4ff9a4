// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>
#include <string>
#include <string_view>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "tls/openssl_pointers.hpp"

namespace segserve::tls {

/// The time in which certificates are valid.
struct Validity {
  std::chrono::sys_seconds begin;
  std::chrono::sys_seconds end;
};

/// The certificates of a text in PEM, in its order; other parts of the text are skipped. INVALID_ARGUMENT if there is
/// none, or one is damaged.
absl::StatusOr<std::vector<X509Pointer>> parse_certificates(std::string_view pem);

/// The private key of a text in PEM. INVALID_ARGUMENT if there is none, or it is damaged or encrypted.
absl::StatusOr<KeyPointer> parse_key(std::string_view pem);

/// INVALID_ARGUMENT unless the key belongs to the first certificate, the others are its chain, and OpenSSL accepts them
/// in a handshake.
absl::Status check_pair(const std::vector<X509Pointer>& chain, EVP_PKEY& key);

/// The time in which all of the certificates are valid. There must be one.
Validity validity_of(const std::vector<X509Pointer>& certificates);
Validity validity_of(const X509& certificate);

/// The host names and addresses for which a certificate is; if it lists none, its common name. No more than five.
std::vector<std::string> names_of(const X509& certificate);

/// A name as in "CN=robot-7,O=Example". Control characters are escaped, and what is long is cut.
std::string text_of(const X509_NAME* name);

/// A time as in "2026-11-29 10:52:38 UTC".
std::string text_of(std::chrono::sys_seconds time);

}  // namespace segserve::tls
