// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "absl/status/statusor.h"

namespace segserve::segctl {

/// All bytes of a file or pipe, or of standard input for "-" (core/base/input_bytes.hpp). The message of an error names
/// the path: NOT_FOUND, INVALID_ARGUMENT (a folder, a device, or larger than 4 GiB), UNAVAILABLE if reading fails, or
/// CANCELLED if a signal came while an Interrupt lives.
absl::StatusOr<std::string> read_input(const std::string& path);

/// The name of an input in messages: that of "-" is "standard input".
std::string input_name(const std::string& path);

}  // namespace segserve::segctl
