// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "absl/status/statusor.h"
#include "nlohmann/json.hpp"
#include "segserve/codec/read_options.hpp"

namespace segserve::segctl {

/// Describes the file of a cloud, without segmenting it: an object with file, format, bytes, points, width, height,
/// finite, color, labels, attributes, box and spacing (in the file's unit), unit, view, view_rule, placement,
/// voxel_resolution (meters; one at which a voxel holds about four points) and warnings. Errors are those of read_input
/// and decode_cloud.
absl::StatusOr<nlohmann::ordered_json> file_info(const std::string& path, codec::ReadOptions options);

/// Describes a recording: an object with file, format and topics, each of which has name, type, encoding, messages and
/// has_frames. Errors are those of client::list_topics.
absl::StatusOr<nlohmann::ordered_json> recording_info(const std::string& path);

/// Either of them as a few lines for people.
std::string file_info_text(const nlohmann::ordered_json& info);
std::string recording_info_text(const nlohmann::ordered_json& info);

}  // namespace segserve::segctl
