// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "absl/status/statusor.h"
#include "segserve/codec/placement.hpp"
#include "segserve/options.hpp"
#include "segserve/prompts.hpp"
#include "segserve/v1/prompts.pb.h"
#include "segserve/wire/outputs.hpp"

namespace segserve::wire {

/// The message of the prompts, whose positions are in the coordinates of the payload.
v1::Prompts to_message(const Prompts& prompts);

/// The prompts of a message. Appends every fault to `faults`, with paths such as "prompts.include[0]".
Prompts from_message(const v1::Prompts& message, std::vector<FieldViolation>& faults);

/// Faults as from_message tells them: INVALID_ARGUMENT, INVALID_FIELD; OK without any.
absl::Status check(const Prompts& prompts);

/// Selects by prompts in a cloud that was segmented with `options`, in the coordinates of the cloud; returns nothing
/// without prompts. `placement` leads from the coordinates of the prompts to those of the cloud. It has statistics if
/// `outputs` asks for segments. INVALID_ARGUMENT, INVALID_FIELD names every prompt that stands for no point. CANCELLED,
/// DEADLINE_EXCEEDED.
absl::StatusOr<std::optional<PromptedSelection>> select_by_prompts(
    const CloudView& cloud, const codec::Placement& placement, const Segmentation& segmentation, const Options& options,
    const Outputs& outputs, const std::optional<Prompts>& prompts, const StopToken& stop);

/// The message of what was selected, without its labels.
v1::Selection to_message(const PromptedSelection& selected);

/// Reads the selection in a cloud of `points` points with `supervoxels` supervoxels; the labels stay empty.
/// INVALID_ARGUMENT, MALFORMED_PAYLOAD, with a message that names the field, if a number is out of its range.
absl::StatusOr<PromptedSelection> from_message(const v1::Selection& message, std::uint64_t points,
                                               std::uint32_t supervoxels);

}  // namespace segserve::wire
