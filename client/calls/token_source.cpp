// SPDX-License-Identifier: Apache-2.0
#include "client/calls/token_source.hpp"

#include <arpa/inet.h>
#include <netinet/in.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <fstream>
#include <utility>

#include "absl/strings/ascii.h"
#include "core/base/status_macros.hpp"
#include "fmt/format.h"

namespace segserve::client {
namespace {

// A server takes at most 16 KiB of headers.
constexpr std::size_t kMostTokenBytes = std::size_t{12} << 10U;

/// Whether it has the letters of a bearer token (RFC 6750, section 2.1).
bool is_token(std::string_view text) {
  constexpr std::string_view kPunctuation = "-._~+/=";
  return !text.empty() && text.size() <= kMostTokenBytes && std::ranges::all_of(text, [&](unsigned char letter) {
    return absl::ascii_isalnum(letter) || kPunctuation.find(static_cast<char>(letter)) != std::string_view::npos;
  });
}

absl::StatusOr<std::string> read_token(const std::string& path) {
  errno = 0;
  std::ifstream in(path, std::ios::binary);
  std::string text(kMostTokenBytes + 2, '\0');
  if (in) in.read(text.data(), static_cast<std::streamsize>(text.size()));
  if (!in.is_open() || in.bad() || in.gcount() == 0) {
    const char* why = errno != 0 ? std::strerror(errno) : "it is empty";
    return absl::NotFoundError(fmt::format("cannot read the token in {}: {}", path, why));
  }
  text.resize(static_cast<std::size_t>(in.gcount()));
  std::string token(absl::StripAsciiWhitespace(text));
  if (!is_token(token)) {
    return absl::InvalidArgumentError(fmt::format("{} does not hold a token, and nothing else", path));
  }
  return token;
}

/// The host of HOST:PORT or [IPv6]:PORT.
std::string host_of(std::string_view address) {
  const std::string_view host = address.substr(0, address.rfind(':'));
  const bool is_bracketed = host.size() > 2 && host.front() == '[' && host.back() == ']';
  return std::string(is_bracketed ? host.substr(1, host.size() - 2) : host);
}

/// A name that begins as an address does, such as 127.example.com, is none.
bool stays_on_this_machine(std::string_view address) {
  if (address.starts_with("unix:") || address.starts_with("unix-abstract:")) return true;
  for (const std::string_view prefix : {"ipv4:", "ipv6:"}) {
    if (address.starts_with(prefix)) address.remove_prefix(prefix.size());
  }
  const std::string host = host_of(address);
  in_addr v4{};
  if (inet_pton(AF_INET, host.c_str(), &v4) == 1) return ntohl(v4.s_addr) >> 24U == 127;
  in6_addr v6{};
  if (inet_pton(AF_INET6, host.c_str(), &v6) == 1) return IN6_IS_ADDR_LOOPBACK(&v6);
  return host == "localhost";
}

}  // namespace

absl::StatusOr<std::shared_ptr<TokenSource>> TokenSource::make(const ClientOptions& options) {
  std::string token = options.token;
  if (!options.token_file.empty()) {
    if (!token.empty()) return absl::InvalidArgumentError("there are both a token and a file that holds one");
    ASSIGN_OR_RETURN(token, read_token(options.token_file));
  } else if (!token.empty() && !is_token(token)) {
    return absl::InvalidArgumentError("the token has letters that no bearer token has");
  }
  return std::shared_ptr<TokenSource>(new TokenSource(std::move(token), options.token_file));
}

std::string TokenSource::token() {
  absl::StatusOr<std::string> read = absl::NotFoundError("");
  if (!file_.empty()) read = read_token(file_);
  const MutexLock lock(mutex_);
  if (read.ok()) token_ = *std::move(read);
  return token_;
}

absl::Status check_plain_text_token(std::string_view address) {
  if (stays_on_this_machine(address)) return absl::OkStatus();
  return absl::InvalidArgumentError(fmt::format(
      "the token is not sent to {}, because the connection is not encrypted, and whoever listens in could use "
      "it; insecure-token allows that",
      address));
}

}  // namespace segserve::client
