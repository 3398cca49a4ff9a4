// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>

#include "segserve/cloud.hpp"
#include "segserve/codec/labeled_cloud.hpp"

namespace segserve::recording {

/// Chooses the view of a recorded cloud by the rule of client::TopicReader, and says so in view_rule. `frame_id` is the
/// name of its frame. In a CAMERA cloud, points at (0, 0, 0) become NaN. A given view is taken as it is.
void choose_view(const std::string& frame_id, const std::optional<View>& given, codec::LabeledCloud& content);

}  // namespace segserve::recording
