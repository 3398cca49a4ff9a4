// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>

#include "segserve/cloud.hpp"
#include "segserve/codec/labeled_cloud.hpp"

namespace segserve::recording {

/// The line for people about a view that the caller gave.
std::string given_view_rule(const View& view);

/// Chooses the view of a recorded cloud by the rule of client::TopicReader, and says so in view_rule. `frame_id` is the
/// name of its frame, and `has_pose` tells that its points lie in a frame of their own that is moved against it
/// (PointCloud2::has_pose).
void choose_view(const std::string& frame_id, bool has_pose, codec::LabeledCloud& content);

}  // namespace segserve::recording
