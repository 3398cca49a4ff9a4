// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <string_view>

namespace segserve::server {

/// The address that all connections of a client have in common, from gRPC's name of a peer, such as
/// "ipv4:192.0.2.7:40312": it has no port, and of an IPv6 address it keeps the network of 64 bits, because a host has
/// all of that. Peers at a unix socket are one client.
std::string client_address(std::string_view peer);

/// A name for the connection of a peer: its address and port, alike for every way in which they are written.
std::string connection_name(std::string_view peer);

}  // namespace segserve::server
