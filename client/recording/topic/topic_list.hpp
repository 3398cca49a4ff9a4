// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "client/recording/message_source.hpp"
#include "segserve/client/topic_reader.hpp"

namespace segserve::recording {

/// The topics of a recording by name. The channels of a topic count together; the first one gives its type.
std::vector<client::TopicInfo> topic_list(const Contents& contents);

/// The topic of that name or, without a name, the only one with frames. INVALID_ARGUMENT, which lists the topics, if
/// there is none, or several.
absl::StatusOr<client::TopicInfo> choose_topic(const std::vector<client::TopicInfo>& topics, const std::string& name);

}  // namespace segserve::recording
