// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <span>
#include <string>

#include "absl/status/statusor.h"
#include "client/recording/topic/frame_reader.hpp"

namespace segserve::recording {

/// The message that a frame was made of, with a label for each point (see add_labels). INVALID_ARGUMENT if the message
/// becomes too large.
absl::StatusOr<std::string> labeled_message(const RecordedFrame& recorded, std::span<const std::uint32_t> labels);

}  // namespace segserve::recording
