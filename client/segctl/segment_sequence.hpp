// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "absl/status/status.h"
#include "client/segctl/segment_arguments.hpp"

namespace segserve::segctl {

/// `segctl segment --track` on a folder: its clouds are frames of one sequence (read_sequence), through a server or in
/// this process. With --out-dir each becomes a PCD file whose labels are the ids of the tracks. A frame that fails
/// stops no other, and the tracks go on without it.
absl::Status segment_sequence(const SegmentArguments& arguments);

}  // namespace segserve::segctl
