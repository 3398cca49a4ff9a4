// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>
#include <string>
#include <variant>

#include "server/options/server_options.hpp"
#include "spdlog/common.h"

namespace segserve::server {

/// The flags of the program `segserve`.
struct Flags {
  ServerOptions server;
  spdlog::level::level_enum log_level = spdlog::level::info;
  std::string port_file;                             ///< empty: write none
  std::chrono::milliseconds listener_check{10'000};  ///< between connections of the server to itself; 0: never
};

/// Reads the flags. Returns an exit code instead if there is nothing to serve: 0 after --help or --version, 2 after
/// wrong flags, which it has reported on standard error.
std::variant<Flags, int> parse_flags(int argc, const char* const* argv);

}  // namespace segserve::server
