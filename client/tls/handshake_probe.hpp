// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>
#include <optional>
#include <string>
#include <vector>

#include "client/tls/client_tls.hpp"
#include "openssl/x509_vfy.h"
#include "tls/openssl_pointers.hpp"

namespace segserve::client {

/// Where a server is reached by TCP.
struct HostAndPort {
  std::string host;
  std::string port;
};

/// The host and port of an address as gRPC takes it; the first, if it lists several. Nothing for a unix socket, and for
/// names that only gRPC can resolve.
std::optional<HostAndPort> host_and_port(const std::string& address);

/// The facts that a handshake with a server has shown.
struct HandshakeReport {
  enum class End {
    kUnknown,  ///< no connection could be made, or nothing came in time
    kNotTls,   ///< the server speaks something else
    kFailed,   ///< one end ended the handshake: see `error`
    kClosed,   ///< the server took our part of the handshake, and then closed the connection
    kGreeted,  ///< the server is ready for calls
  } end = End::kUnknown;
  std::string error = {};                            ///< in the words of OpenSSL
  tls::X509Pointer server_certificate = {};          ///< null if there came none
  int verify_error = X509_V_OK;                      ///< the first fault of the server's certificates
  tls::X509Pointer wrong_certificate = {};           ///< whose fault it is
  bool wants_client_certificate = false;             ///< the server asked for one
  std::vector<std::string> client_authorities = {};  ///< whose certificates it asked for, if it said so
  bool speaks_http2 = false;
};

/// Connects to a server, shakes hands with what `tls` holds, or with nothing if that is unset, and waits for the server
/// to greet. It goes on when it finds a fault of the server's certificate. Takes no longer than `timeout`, apart from
/// the resolution of the name.
HandshakeReport probe_handshake(const HostAndPort& server, const std::optional<ClientTls>& tls,
                                std::chrono::milliseconds timeout);

}  // namespace segserve::client
