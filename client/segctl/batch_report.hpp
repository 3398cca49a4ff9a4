// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "absl/status/status.h"
#include "client/segctl/batch.hpp"
#include "client/segctl/batch_progress.hpp"

namespace segserve::segctl {

/// Writes the JSON lines, the contact sheet and the counts that a batch is asked for, and one error line for each file
/// that failed. `outcomes` has one entry per input; `stopped` says why some of them are open, or is OK. Returns the
/// status of the whole batch: see run_batch.
absl::Status report_batch(const BatchJob& job, const std::vector<FileOutcome>& outcomes, const absl::Status& stopped);

}  // namespace segserve::segctl
