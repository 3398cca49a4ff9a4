#pragma once

#include <string>
#include <variant>

#include "server/options/server_options.hpp"
#include "spdlog/common.h"

namespace segserve::server {

/// What the command line says.
struct Flags {
  ServerOptions server;
  spdlog::level::level_enum log_level = spdlog::level::info;
  std::string port_file;  ///< empty: none
};

/// The flags, or the exit code if there is nothing to run: --help, --version, or wrong flags (2), which have been
/// reported on standard error.
std::variant<Flags, int> parse_flags(int argc, const char* const* argv);

}  // namespace segserve::server
