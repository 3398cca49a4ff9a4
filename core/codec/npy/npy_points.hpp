// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "absl/status/statusor.h"
#include "core/codec/npy/npy_array.hpp"
#include "core/codec/npy/npy_table.hpp"
#include "segserve/codec/decode_limits.hpp"
#include "segserve/codec/labeled_cloud.hpp"
#include "segserve/codec/read_options.hpp"
#include "segserve/stop_token.hpp"

namespace segserve::codec {

/// A cloud from a single array, see decode_npy. `warnings` are those so far.
absl::StatusOr<LabeledCloud> read_array(const NpyArray& array, std::vector<Warning> warnings,
                                        const DecodeLimits& limits, const ReadOptions& options, const StopToken& stop);

/// A cloud from a table. It takes the warnings so far, to which `points` adds.
absl::StatusOr<LabeledCloud> read_table(NpyTable& points, std::vector<Warning>& warnings, const ReadOptions& options,
                                        const StopToken& stop);

}  // namespace segserve::codec
