// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <string_view>

#include "absl/status/status.h"
#include "absl/status/statusor.h"

namespace segserve::server {

/// Where to listen: HOST:PORT, [IPv6]:PORT or unix:PATH.
struct ListenAddress {
  std::string host;  ///< of a unix socket, its path
  std::string port;  ///< empty for a unix socket
  bool is_unix = false;

  /// True if only this machine can reach it: a unix socket, "localhost", 127.0.0.0/8 or ::1.
  bool is_loopback() const;
};

/// INVALID_ARGUMENT if the text is no such address.
absl::StatusOr<ListenAddress> parse_listen_address(std::string_view text);

/// The address with the port that was picked for port 0.
std::string with_port(const ListenAddress& address, int port);

/// Why the address cannot be bound, e.g. "Address already in use"; empty if it can be bound now. gRPC does not say why
/// it failed to bind an address, so this fills in the error message.
std::string why_not_bindable(const ListenAddress& address);

}  // namespace segserve::server
