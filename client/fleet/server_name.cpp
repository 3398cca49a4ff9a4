// SPDX-License-Identifier: Apache-2.0
#include "client/fleet/server_name.hpp"

#include <arpa/inet.h>

#include <algorithm>
#include <array>
#include <charconv>

#include "core/base/status_macros.hpp"
#include "fmt/format.h"

namespace segserve::client {
namespace {

constexpr std::string_view kDefaultPort = "50051";

std::string_view trimmed(std::string_view text) {
  const std::size_t begin = text.find_first_not_of(" \t");
  if (begin == std::string_view::npos) return {};
  return text.substr(begin, text.find_last_not_of(" \t") - begin + 1);
}

/// Whether gRPC resolves the name by a rule of its own, instead of as HOST:PORT.
bool has_resolver(std::string_view address) {
  constexpr std::array<std::string_view, 7> kSchemes{
      "dns:", "unix:", "unix-abstract:", "ipv4:", "ipv6:", "passthrough:", "xds:"};
  return std::ranges::any_of(kSchemes, [address](std::string_view scheme) { return address.starts_with(scheme); });
}

absl::StatusOr<std::string> with_port(std::string_view address) {
  if (has_resolver(address)) return std::string(address);
  if (address.find("://") != std::string_view::npos || address.find('/') != std::string_view::npos) {
    return absl::InvalidArgumentError(fmt::format(
        "'{}' is a URL; the address of a server is HOST:PORT, such as 127.0.0.1:{}", address, kDefaultPort));
  }
  const bool is_bare_ipv6 = !address.starts_with('[') && std::ranges::count(address, ':') > 1;
  if (is_bare_ipv6) return fmt::format("[{}]:{}", address, kDefaultPort);
  const std::size_t colon = address.rfind(':');
  if (colon == std::string_view::npos || address.ends_with(']')) return fmt::format("{}:{}", address, kDefaultPort);
  unsigned port = 0;
  const char* const end = address.data() + address.size();
  const auto parsed = std::from_chars(address.data() + colon + 1, end, port);
  if (parsed.ec != std::errc{} || parsed.ptr != end || port == 0 || port > 65535) {
    return absl::InvalidArgumentError(fmt::format("the port of '{}' is no number from 1 to 65535", address));
  }
  return std::string(address);
}

bool is_ip_address(const std::string& host) {
  in6_addr address{};
  return host.find(':') != std::string::npos || inet_pton(AF_INET, host.c_str(), &address) == 1;
}

}  // namespace

absl::StatusOr<std::vector<std::string>> parse_addresses(std::string_view text) {
  if (trimmed(text).empty()) return absl::InvalidArgumentError("the server's address is empty");
  std::vector<std::string> addresses;
  for (std::size_t begin = 0; begin <= text.size();) {
    const std::size_t end = std::min(text.find(',', begin), text.size());
    const std::string_view address = trimmed(text.substr(begin, end - begin));
    if (address.empty()) return absl::InvalidArgumentError(fmt::format("there is an empty address in '{}'", text));
    ASSIGN_OR_RETURN(addresses.emplace_back(), with_port(address));
    begin = end + 1;
  }
  return addresses;
}

std::optional<HostName> name_to_look_up(std::string_view address) {
  constexpr std::string_view kDns = "dns:", kNoServer = "///";
  if (address.starts_with(kDns)) {
    address.remove_prefix(kDns.size());
    if (address.starts_with(kNoServer)) address.remove_prefix(kNoServer.size());
  } else if (has_resolver(address)) {
    return std::nullopt;
  }
  if (address.find('/') != std::string_view::npos) return std::nullopt;  // names a DNS server to ask
  const std::size_t colon = address.rfind(':');
  HostName name{.host = std::string(address.substr(0, colon)), .port = std::string(kDefaultPort)};
  if (colon != std::string_view::npos) name.port = address.substr(colon + 1);
  if (name.host.empty() || name.host == "localhost" || is_ip_address(name.host)) return std::nullopt;
  return name;
}

}  // namespace segserve::client
