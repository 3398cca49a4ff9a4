// SPDX-License-Identifier: Apache-2.0
#include "server/options/listen_address.hpp"

#include <arpa/inet.h>
#include <netdb.h>
#include <sys/socket.h>
#include <sys/un.h>
#include <unistd.h>

#include <cerrno>
#include <charconv>
#include <cstring>
#include <memory>

#include "core/base/loopback_host.hpp"
#include "fmt/format.h"

namespace segserve::server {
namespace {

constexpr std::string_view kUnixPrefix = "unix:";

bool is_port(std::string_view text) {
  unsigned port = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), port);
  return error == std::errc() && end == text.data() + text.size() && port <= 65535;
}

}  // namespace

bool ListenAddress::is_loopback() const { return is_unix || is_loopback_host(host); }

absl::StatusOr<ListenAddress> parse_listen_address(std::string_view text) {
  if (text.starts_with(kUnixPrefix) && text.size() > kUnixPrefix.size()) {
    text.remove_prefix(kUnixPrefix.size());
    if (text.size() >= sizeof(sockaddr_un{}.sun_path)) {
      return absl::InvalidArgumentError(fmt::format("the path of a unix socket has at most {} bytes, and {} has {}",
                                                    sizeof(sockaddr_un{}.sun_path) - 1, text, text.size()));
    }
    return ListenAddress{std::string(text), "", true};
  }
  const std::size_t colon = text.rfind(':');
  if (colon != std::string_view::npos) {
    std::string_view host = text.substr(0, colon);
    const bool bracketed = host.size() > 2 && host.front() == '[' && host.back() == ']';
    if (bracketed) host = host.substr(1, host.size() - 2);
    const bool is_host = !host.empty() && (bracketed || host.find_first_of(":[]") == std::string_view::npos);
    if (is_host && is_port(text.substr(colon + 1))) {
      return ListenAddress{std::string(host), std::string(text.substr(colon + 1)), false};
    }
  }
  return absl::InvalidArgumentError(
      fmt::format("'{}' is no address to listen on: HOST:PORT, [IPv6]:PORT or unix:PATH", text));
}

std::string with_port(const ListenAddress& address, int port) {
  if (address.is_unix) return fmt::format("{}{}", kUnixPrefix, address.host);
  const bool is_v6 = address.host.find(':') != std::string::npos;
  return fmt::format(fmt::runtime(is_v6 ? "[{}]:{}" : "{}:{}"), address.host, port);
}

std::string why_not_bindable(const ListenAddress& address) {
  if (address.is_unix) return "is the path writable, and not in use?";
  addrinfo hints{};
  hints.ai_socktype = SOCK_STREAM;
  hints.ai_flags = AI_PASSIVE | AI_NUMERICSERV;
  addrinfo* found = nullptr;
  if (const int error = getaddrinfo(address.host.c_str(), address.port.c_str(), &hints, &found); error != 0) {
    return gai_strerror(error);
  }
  const std::unique_ptr<addrinfo, decltype(&freeaddrinfo)> addresses(found, freeaddrinfo);
  for (const addrinfo* each = found; each != nullptr; each = each->ai_next) {
    const int descriptor = socket(each->ai_family, each->ai_socktype, each->ai_protocol);
    if (descriptor < 0) return std::strerror(errno);
    const int result = bind(descriptor, each->ai_addr, each->ai_addrlen);
    const int error = errno;
    close(descriptor);
    if (result != 0) return std::strerror(error);
  }
  return "";
}

}  // namespace segserve::server
