// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "absl/status/status.h"

namespace segserve::segctl {

/// The documented exit codes.
enum ExitCode : int {
  kSuccess = 0,
  kFailed = 1,    ///< The operation failed: server unreachable or not serving, deadline exceeded, disk full.
  kBadInput = 2,  ///< The input or the usage is wrong: options, files, clouds.
};

/// kBadInput for INVALID_ARGUMENT (from the server, too), OUT_OF_RANGE and NOT_FOUND (a file); kFailed for other
/// errors.
ExitCode exit_code(const absl::Status& status);

}  // namespace segserve::segctl
