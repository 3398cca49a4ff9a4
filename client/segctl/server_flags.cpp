// SPDX-License-Identifier: Apache-2.0
#include "client/segctl/server_flags.hpp"

#include <cstdint>
#include <cstdlib>

#include "client/segctl/messages.hpp"
#include "core/base/status_macros.hpp"
#include "core/base/status_text.hpp"
#include "fmt/format.h"
#include "proto/wire/status_message.hpp"

namespace segserve::segctl {

void ServerFlags::add_to(CLI::App& app, double default_timeout_s) {
  const char* from_environment = std::getenv("SEGCTL_SERVER");
  const bool has_environment = from_environment != nullptr && *from_environment != '\0';
  address_ = has_environment ? from_environment : client::ClientOptions{}.address;
  timeout_s_ = default_timeout_s;
  server_option_ = app.add_option("--server", address_,
                                  "address of the server, host:port (default port: 50051); several are separated by "
                                  "commas; also from SEGCTL_SERVER")
                       ->type_name("ADDRESS")
                       ->capture_default_str()
                       ->group("Server");
  timeout_option_ = app.add_option("--timeout", timeout_s_, "give up after this many seconds")
                        ->type_name("SECONDS")
                        ->capture_default_str()
                        ->group("Server");
  app.add_flag("--use-proxy", use_proxy_, "connect through the proxy of the environment, but never to this machine")
      ->group("Server");
}

absl::StatusOr<std::chrono::milliseconds> ServerFlags::timeout() const {
  constexpr double kDay = 86400;
  if (!(timeout_s_ >= 0.001 && timeout_s_ <= kDay)) {
    return absl::InvalidArgumentError(fmt::format("timeout: {} is not in [0.001, {}] s", timeout_s_, kDay));
  }
  return std::chrono::milliseconds(static_cast<std::int64_t>(timeout_s_ * 1000));
}

absl::StatusOr<client::Client> ServerFlags::connect(bool fallback_to_local) const {
  ASSIGN_OR_RETURN(const auto limit, timeout());
  return client::Client::connect(
      {.address = address_, .timeout = limit, .fallback_to_local = fallback_to_local, .use_proxy = use_proxy_});
}

absl::Status or_locally(const absl::Status& status) {
  const bool server_answered = wire::details_of(status).reason != wire::ErrorReason::kUnspecified;
  if (!absl::IsUnavailable(status) || server_answered) return status;
  const std::string message = message_of(status);
  return absl::UnavailableError(message + (message.ends_with('?') ? "" : ";") + " --local works without");
}

void warn_of_fallback(const std::string& address) {
  print_warning(fmt::format("no server is in reach at {}: segmented in this process", address));
}

}  // namespace segserve::segctl
