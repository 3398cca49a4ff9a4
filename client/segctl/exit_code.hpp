// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "absl/status/status.h"

namespace segserve::segctl {

/// The documented exit codes.
enum ExitCode : int {
  kSuccess = 0,
  kFailed = 1,         ///< The operation failed: server unreachable or not serving, deadline exceeded, disk full.
  kBadInput = 2,       ///< The input or the usage is wrong: options, files, clouds.
  kInterrupted = 130,  ///< Ctrl-C or SIGTERM stopped a batch.
};

/// kBadInput for INVALID_ARGUMENT (from the server, too), OUT_OF_RANGE and NOT_FOUND (a file); kInterrupted for
/// CANCELLED; kFailed for other errors.
ExitCode exit_code(const absl::Status& status);

}  // namespace segserve::segctl
