// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <string_view>

#include "absl/status/statusor.h"

// Files that have a label for each point, and nothing else of the cloud.
namespace segserve::codec {

/// ScanNet's NAME.segs.json: {"params": {}, "sceneId": "NAME", "segIndices": [..]}.
std::string encode_segs_json(std::span<const std::uint32_t> label, std::string_view scene);

/// SemanticKITTI's NAME.label: 32 bits for each point, little endian. The upper 16 bits are the instance, which is the
/// segment, and the lower 16 bits the semantic class, which is 0, "unlabeled" (semantic-kitti-api,
/// auxiliary/laserscan.py). INVALID_ARGUMENT if a label does not fit in 16 bits.
absl::StatusOr<std::string> encode_kitti_label(std::span<const std::uint32_t> label);

}  // namespace segserve::codec
