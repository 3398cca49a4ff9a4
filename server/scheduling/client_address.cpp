// SPDX-License-Identifier: Apache-2.0
#include "server/scheduling/client_address.hpp"

#include <arpa/inet.h>
#include <netinet/in.h>

#include <algorithm>
#include <array>

namespace segserve::server {
namespace {

constexpr std::string_view kIpv6 = "ipv6:";

/// The address between the brackets, which gRPC writes as they are or escaped as in a URI, without a zone.
std::string_view without_brackets(std::string_view host) {
  for (const std::string_view bracket : {"[", "%5B", "%5b"}) {
    if (host.starts_with(bracket)) host.remove_prefix(bracket.size());
  }
  return host.substr(0, host.find_first_of("]%"));
}

std::string network_of(std::string_view host) {
  in6_addr address{};
  const std::string text(without_brackets(host));
  if (inet_pton(AF_INET6, text.c_str(), &address) != 1) return std::string(kIpv6) + text;
  std::array<char, INET6_ADDRSTRLEN> written{};
  if (IN6_IS_ADDR_V4MAPPED(&address)) {
    inet_ntop(AF_INET, &address.s6_addr[12], written.data(), written.size());
    return std::string("ipv4:") + written.data();
  }
  constexpr std::size_t kNetworkBytes = 8;
  std::fill(std::begin(address.s6_addr) + kNetworkBytes, std::end(address.s6_addr), std::uint8_t{0});
  inet_ntop(AF_INET6, &address, written.data(), written.size());
  return std::string(kIpv6) + written.data() + "/64";
}

}  // namespace

std::string client_address(std::string_view peer) {
  if (peer.starts_with("unix")) return "unix";
  const std::string_view address = peer.substr(0, peer.rfind(':'));
  return address.starts_with(kIpv6) ? network_of(address.substr(kIpv6.size())) : std::string(address);
}

std::string connection_name(std::string_view peer) {
  return client_address(peer).append(" ").append(peer.substr(peer.rfind(':') + 1));
}

}  // namespace segserve::server
