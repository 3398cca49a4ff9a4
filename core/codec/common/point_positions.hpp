// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>

#include "absl/status/status.h"
#include "core/base/stop_check.hpp"
#include "core/codec/common/column.hpp"
#include "core/codec/view/view_choice.hpp"
#include "segserve/codec/labeled_cloud.hpp"
#include "segserve/codec/read_options.hpp"

namespace segserve::codec {

/// Converts the coordinates of a file to those of `out.cloud`, whose planes and shape have their sizes already: in
/// meters, in the view that choose_view finds, and near the origin. A WORLD cloud whose median is farther than 512 m
/// from 0 along any axis is moved by its median, rounded to about a meter, before its values become floats, so that
/// they stay exact. Sets the view, its rule, the placement and, if it is wanted and not what the cloud has, the
/// position in the file. `are_floats`: the file calls its coordinates floats of 32 bits, though text has them as
/// doubles. `evidence.given` is that of the options. CANCELLED, DEADLINE_EXCEEDED.
absl::Status read_positions(const std::array<Column, 3>& columns, bool are_floats, ViewEvidence evidence,
                            const ReadOptions& options, StopCheck& check, LabeledCloud& out);

}  // namespace segserve::codec
