// SPDX-License-Identifier: Apache-2.0
#include "client/fleet/host_lookup.hpp"

#include <netdb.h>
#include <sys/socket.h>

#include <array>
#include <memory>

namespace segserve::client {

absl::StatusOr<std::vector<HostAddress>> look_up_host(const HostName& name) {
  addrinfo wanted{};
  wanted.ai_family = AF_UNSPEC;
  wanted.ai_socktype = SOCK_STREAM;
  addrinfo* found = nullptr;
  const int error = getaddrinfo(name.host.c_str(), nullptr, &wanted, &found);
  if (error != 0) return absl::UnavailableError(gai_strerror(error));
  const std::unique_ptr<addrinfo, decltype(&freeaddrinfo)> owner(found, freeaddrinfo);
  std::vector<HostAddress> addresses;
  for (const addrinfo* entry = found; entry != nullptr; entry = entry->ai_next) {
    std::array<char, NI_MAXHOST> text{};
    const bool is_text =
        getnameinfo(entry->ai_addr, entry->ai_addrlen, text.data(), text.size(), nullptr, 0, NI_NUMERICHOST) == 0;
    if (!is_text) continue;
    const auto family = entry->ai_family == AF_INET6 ? HostAddress::Family::kIpv6 : HostAddress::Family::kIpv4;
    addresses.push_back({.family = family, .text = text.data()});
  }
  return addresses;
}

}  // namespace segserve::client
