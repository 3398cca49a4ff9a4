// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

namespace segserve::client {

/// How connections are encrypted, and who both ends are. All files are in PEM. They are read again when they have
/// changed, and new connections use what is new.
struct TlsOptions {
  /// The authorities one of which must have signed the server's certificate; empty: those of the system, from the file
  /// that SSL_CERT_FILE names or else the one that the distribution keeps.
  std::string ca_file = {};
  /// The certificate that this client shows, with the chain after it, and the key of it; empty: it shows none. Servers
  /// that check their clients ask for one.
  std::string cert_file = {};
  std::string key_file = {};
  /// The name that must be in the server's certificate; empty: the host of the address.
  std::string server_name = {};
};

}  // namespace segserve::client
