#pragma once

#include <string>

#include "absl/status/statusor.h"

namespace segserve::segctl {

/// All bytes of a file, or of standard input for "-". NOT_FOUND or INVALID_ARGUMENT (a folder,
/// larger than 4 GiB) naming the path; UNAVAILABLE if reading fails.
absl::StatusOr<std::string> read_input(const std::string& path);

/// How a path is called in messages: "-" is "standard input".
std::string input_name(const std::string& path);

}  // namespace segserve::segctl
