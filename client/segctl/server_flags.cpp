// SPDX-License-Identifier: Apache-2.0
#include "client/segctl/server_flags.hpp"

#include <algorithm>
#include <cstdint>
#include <cstdlib>
#include <utility>

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
  const auto add_connection = [&](CLI::Option* option) {
    option->group("Server");
    connection_options_.push_back(option);
    return option;
  };
  add_connection(app.add_flag("--use-proxy", use_proxy_,
                              "connect through the proxy of the environment, but never to this machine"));
  add_connection(app.add_flag("--tls", use_tls_,
                              "encrypt the connection; the authorities of this system confirm who the server is"));
  add_connection(app.add_option("--tls-ca", tls_.ca_file,
                                "encrypt it; the authorities of this file in PEM confirm who the server is"))
      ->type_name("FILE");
  add_connection(
      app.add_option("--tls-cert", tls_.cert_file, "encrypt it, and show the server this certificate in PEM"))
      ->type_name("FILE");
  add_connection(app.add_option("--tls-key", tls_.key_file, "the private key of that certificate"))->type_name("FILE");
  add_connection(app.add_option("--tls-server-name", tls_.server_name,
                                "encrypt it, and expect this name in the server's certificate"))
      ->type_name("NAME");
  add_connection(app.add_option("--token-file", token_file_,
                                "file that holds the bearer token for the server; a token itself is taken from "
                                "SEGCTL_TOKEN"))
      ->type_name("FILE");
  add_connection(app.add_flag("--insecure-token", insecure_token_,
                              "send the token to other machines even as plain text, where whoever listens in can use "
                              "it"));
}

std::optional<std::string> ServerFlags::connection_flag() const {
  const auto given =
      std::ranges::find_if(connection_options_, [](const CLI::Option* option) { return option->count() > 0; });
  return given == connection_options_.end() ? std::nullopt : std::optional((*given)->get_name());
}

absl::StatusOr<std::chrono::milliseconds> ServerFlags::timeout() const {
  constexpr double kDay = 86400;
  if (!(timeout_s_ >= 0.001 && timeout_s_ <= kDay)) {
    return absl::InvalidArgumentError(fmt::format("timeout: {} is not in [0.001, {}] s", timeout_s_, kDay));
  }
  return std::chrono::milliseconds(static_cast<std::int64_t>(timeout_s_ * 1000));
}

absl::StatusOr<client::ClientOptions> ServerFlags::options() const {
  client::ClientOptions options{.address = address_, .use_proxy = use_proxy_};
  ASSIGN_OR_RETURN(options.timeout, timeout());
  const bool wants_tls = use_tls_ || !tls_.ca_file.empty() || !tls_.cert_file.empty() || !tls_.key_file.empty() ||
                         !tls_.server_name.empty();
  if (wants_tls) options.tls = tls_;
  options.token_file = token_file_;
  options.insecure_token = insecure_token_;
  const char* token = std::getenv("SEGCTL_TOKEN");
  if (token != nullptr && token_file_.empty()) options.token = token;
  return options;
}

absl::StatusOr<client::Client> ServerFlags::connect(bool fallback_to_local) const {
  ASSIGN_OR_RETURN(client::ClientOptions wanted, options());
  wanted.fallback_to_local = fallback_to_local;
  return client::Client::connect(std::move(wanted));
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
