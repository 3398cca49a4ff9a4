// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "absl/status/status.h"
#include "client/segctl/segment_arguments.hpp"

namespace segserve::segctl {

/// `segctl segment` with --out-dir or --contact-sheet: see run_batch. The output folder is made if it is missing.
absl::Status segment_many(const SegmentArguments& arguments);

}  // namespace segserve::segctl
