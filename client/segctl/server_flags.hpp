#pragma once

#include <optional>
#include <string>

#include "CLI/CLI.hpp"
#include "absl/status/statusor.h"
#include "segserve/client/client.hpp"

namespace segserve::segctl {

/// The flags --server and --timeout. Must outlive the parsing of the command line.
class ServerFlags {
 public:
  /// Address: --server, else the environment's SEGCTL_SERVER, else 127.0.0.1:50051.
  void add_to(CLI::App& app, double default_timeout_s);

  bool server_given() const { return server_option_->count() > 0; }
  bool timeout_given() const { return timeout_option_->count() > 0; }
  const std::string& address() const { return address_; }

  /// INVALID_ARGUMENT unless above 0 and at most a day.
  absl::StatusOr<std::chrono::milliseconds> timeout() const;
  /// `fallback_to_local` as in client::ClientOptions.
  absl::StatusOr<client::Client> connect(bool fallback_to_local = false) const;

 private:
  std::string address_;
  double timeout_s_ = 0;
  CLI::Option* server_option_ = nullptr;
  CLI::Option* timeout_option_ = nullptr;
};

/// Tells that --fallback-local was of use.
void warn_of_fallback(const std::string& address);

}  // namespace segserve::segctl
