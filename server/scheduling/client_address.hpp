// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <string_view>

namespace segserve::server {

/// The part of gRPC's name of a peer, such as "ipv4:192.0.2.7:40312", that all connections of a machine have in common:
/// the name without the port. Peers at a unix socket are one client.
inline std::string client_address(std::string_view peer) {
  if (peer.starts_with("unix")) return "unix";
  return std::string(peer.substr(0, peer.rfind(':')));
}

}  // namespace segserve::server
