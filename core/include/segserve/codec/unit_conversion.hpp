// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "absl/status/statusor.h"
#include "segserve/cloud.hpp"
#include "segserve/codec/labeled_cloud.hpp"
#include "segserve/codec/read_options.hpp"
#include "segserve/stop_token.hpp"

namespace segserve::codec {

/// A copy of a cloud whose coordinates are in another unit, as a file of it would be read: in meters, near the origin,
/// in the view of the options or else the one that the points make plain. CANCELLED, DEADLINE_EXCEEDED.
absl::StatusOr<LabeledCloud> to_meters(const CloudView& cloud, const ReadOptions& options, const StopToken& stop = {});

}  // namespace segserve::codec
