// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "absl/status/statusor.h"
#include "client/recording/message_source.hpp"
#include "client/recording/topic/message_type.hpp"
#include "segserve/client/topic_reader.hpp"

namespace segserve::recording {

/// The topics of a recording by name. The channels of a topic count together; the first one gives its type.
std::vector<client::TopicInfo> topic_list(const Contents& contents);

/// The topic of that name or, without a name, the only one with clouds or, if there are none, the only one with depth
/// images. INVALID_ARGUMENT, which lists the topics, if there is none, or several.
absl::StatusOr<client::TopicInfo> choose_topic(const Contents& contents, const std::string& name);

/// INVALID_ARGUMENT, which lists the topics, unless the topic `name` has messages of such a kind. `what` completes the
/// sentence "topic /x is no ...".
absl::Status check_topic(const Contents& contents, const std::string& name, bool (*is_right)(MessageKind),
                         std::string_view what);

/// The topic with the camera of a topic of images: `camera_info` beside it, as ROS has it, or else the only one of its
/// namespace with a camera. INVALID_ARGUMENT, which lists the topics, if there is none.
absl::StatusOr<std::string> camera_info_topic(const Contents& contents, const std::string& images);

/// The type of a topic's messages, by its first channel; nothing if there is no such topic, or it is not read.
std::optional<MessageType> type_of_topic(const Contents& contents, const std::string& name);

}  // namespace segserve::recording
