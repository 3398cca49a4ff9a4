// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <span>
#include <string>

#include "absl/status/statusor.h"
#include "client/recording/topic/frame_reader.hpp"

namespace segserve::recording {

/// The cloud that a frame was made of, with a label for each point (see add_labels): in the encoding of its message or,
/// of images, as a PointCloud2 in CDR. INVALID_ARGUMENT if the message becomes too large.
absl::StatusOr<std::string> labeled_message(const RecordedFrame& recorded, std::span<const std::uint32_t> labels);

/// The schema of a PointCloud2 in CDR.
const Schema& point_cloud2_schema();

}  // namespace segserve::recording
