#pragma once

#include <string_view>

#include "absl/status/status.h"

namespace segserve::segctl {

/// The documented exit codes.
enum ExitCode : int {
  kSuccess = 0,
  kFailed = 1,    ///< the operation failed: server unreachable or not serving, deadline, disk full
  kBadInput = 2,  ///< bad input or usage: options, files, clouds
};

/// kBadInput for INVALID_ARGUMENT (the server's too), OUT_OF_RANGE and NOT_FOUND (a file).
ExitCode exit_code(const absl::Status& status);

/// Writes "segctl: <message>" to standard error as exactly one line; its head is red on a terminal
/// unless NO_COLOR is set.
void print_error(std::string_view message);
/// The same in another colour, for what did not go as meant, but went.
void print_warning(std::string_view message);

}  // namespace segserve::segctl
