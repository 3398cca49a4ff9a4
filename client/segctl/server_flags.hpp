// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>
#include <optional>
#include <string>
#include <vector>

#include "CLI/CLI.hpp"
#include "absl/status/statusor.h"
#include "segserve/client/client.hpp"

namespace segserve::segctl {

/// The flags --server, --timeout, --use-proxy, those of TLS, and those of the token. It must outlive the parsing of the
/// command line.
class ServerFlags {
 public:
  /// The address is that of --server, else that of the environment variable SEGCTL_SERVER, else 127.0.0.1:50051.
  void add_to(CLI::App& app, double default_timeout_s);

  bool server_given() const { return server_option_->count() > 0; }
  bool timeout_given() const { return timeout_option_->count() > 0; }
  const std::string& address() const { return address_; }
  /// The first flag that was given and says how to connect, such as --tls-ca.
  std::optional<std::string> connection_flag() const;

  /// INVALID_ARGUMENT unless it is at least a millisecond and at most a day.
  absl::StatusOr<std::chrono::milliseconds> timeout() const;
  /// Makes options of the flags. INVALID_ARGUMENT as of timeout(). The token is that of --token-file, else that of the
  /// environment variable SEGCTL_TOKEN.
  absl::StatusOr<client::ClientOptions> options() const;
  /// `fallback_to_local` as in client::ClientOptions. INVALID_ARGUMENT if a file of TLS is wrong.
  absl::StatusOr<client::Client> connect(bool fallback_to_local = false) const;

 private:
  std::string address_;
  double timeout_s_ = 0;
  bool use_proxy_ = false;
  bool use_tls_ = false;
  client::TlsOptions tls_;
  std::string token_file_;
  bool insecure_token_ = false;
  CLI::Option* server_option_ = nullptr;
  CLI::Option* timeout_option_ = nullptr;
  std::vector<const CLI::Option*> connection_options_;  ///< those of connection_flag
};

/// The status of a call; if no server was in reach, the message also says that --local works without one.
absl::Status or_locally(const absl::Status& status);

/// Tells on standard error that --fallback-local took the place of a server.
void warn_of_fallback(const std::string& address);

}  // namespace segserve::segctl
