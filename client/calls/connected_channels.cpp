// SPDX-License-Identifier: Apache-2.0
#include "client/calls/connected_channels.hpp"

#include <algorithm>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "client/calls/token_source.hpp"
#include "client/fleet/server_name.hpp"
#include "client/tls/tls_source.hpp"
#include "core/base/status_macros.hpp"
#include "fmt/format.h"

namespace segserve::client {
namespace {

/// A server does not speak TLS on a unix socket.
absl::Status check_no_unix_socket(const std::vector<std::string>& addresses) {
  const auto found = std::ranges::find_if(addresses, [](const auto& address) { return address.starts_with("unix"); });
  if (found == addresses.end()) return absl::OkStatus();
  return absl::InvalidArgumentError(fmt::format("{} is a unix socket, which has no TLS", *found));
}

}  // namespace

absl::StatusOr<std::shared_ptr<Channels>> make_channels(const ClientOptions& options) {
  ASSIGN_OR_RETURN(const std::vector<std::string> addresses, parse_addresses(options.address));
  if (options.timeout <= std::chrono::milliseconds::zero()) {
    return absl::InvalidArgumentError(fmt::format("timeout: {} ms is not above 0", options.timeout.count()));
  }
  std::optional<TlsSource> tls;
  if (options.tls) {
    RETURN_IF_ERROR(check_no_unix_socket(addresses));
    ASSIGN_OR_RETURN(tls, TlsSource::load(*options.tls));
  }
  ASSIGN_OR_RETURN(std::shared_ptr<TokenSource> token, TokenSource::make(options));
  if (!token->token().empty() && !options.tls && !options.insecure_token) {
    for (const std::string& address : addresses) RETURN_IF_ERROR(check_plain_text_token(address));
  }
  return std::make_shared<Channels>(addresses, options.use_proxy, std::move(tls), std::move(token));
}

}  // namespace segserve::client
