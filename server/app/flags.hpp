// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>
#include <string>
#include <variant>

#include "server/log/log_formatter.hpp"
#include "server/options/server_options.hpp"
#include "spdlog/common.h"

namespace segserve::server {

/// The flags of the program `segserve`.
struct Flags {
  ServerOptions server;
  spdlog::level::level_enum log_level = spdlog::level::info;
  LogFormat log_format = LogFormat::kText;
  std::string otlp_endpoint;     ///< where traces go; empty: there are none
  double otlp_sample_ratio = 1;  ///< the share of frames to record whose client sent no trace context
  std::string port_file, health_port_file, metrics_port_file, http_port_file;  ///< empty: write none
  std::chrono::milliseconds listener_check{10'000};  ///< between connections of the server to itself; 0: never
  bool check_only = false;                           ///< check everything, and do not serve
};

/// Reads the flags, the environment and the file of settings. Returns an exit code instead if there is nothing to
/// serve: 0 after --help, --version or --print-config, 2 after wrong settings, which it has reported on standard error.
std::variant<Flags, int> parse_flags(int argc, const char* const* argv);

}  // namespace segserve::server
