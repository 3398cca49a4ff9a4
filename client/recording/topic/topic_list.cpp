// SPDX-License-Identifier: Apache-2.0
#include "client/recording/topic/topic_list.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <map>

#include "client/recording/topic/message_type.hpp"

namespace segserve::recording {
namespace {

using client::TopicInfo;

constexpr std::size_t kMostListed = 50;

/// The topics, those with frames first.
std::string list_text(std::vector<TopicInfo> topics) {
  if (topics.empty()) return "it has no topics";
  std::ranges::stable_partition(topics, &TopicInfo::has_frames);
  std::string text;
  for (std::size_t i = 0; i < std::min(kMostListed, topics.size()); ++i) {
    const TopicInfo& topic = topics[i];
    text += fmt::format("{}{} ({}, {}, {} message{})", i == 0 ? "" : ", ", topic.name,
                        topic.type.empty() ? "no schema" : topic.type, topic.encoding, topic.messages,
                        topic.messages == 1 ? "" : "s");
  }
  if (topics.size() > kMostListed) text += fmt::format(" and {} more", topics.size() - kMostListed);
  return "its topics are " + text;
}

constexpr const char* kReadable = "sensor_msgs/PointCloud2 can";

}  // namespace

std::vector<TopicInfo> topic_list(const Contents& contents) {
  std::map<std::string, TopicInfo> topics;
  for (const auto& [number, channel] : contents.definitions.channels) {
    const auto [entry, is_new] = topics.try_emplace(channel.topic);
    TopicInfo& topic = entry->second;
    if (is_new) {
      const Schema& schema = contents.definitions.schema_of(channel);
      const auto type = message_type(channel, schema);
      topic = {channel.topic, schema.name, channel.message_encoding, 0, type && has_frames(type->kind)};
    }
    if (const auto count = contents.messages.find(number); count != contents.messages.end()) {
      topic.messages += count->second;
    }
  }
  std::vector<TopicInfo> list;
  for (auto& [name, topic] : topics) list.push_back(std::move(topic));
  return list;
}

absl::StatusOr<TopicInfo> choose_topic(const std::vector<TopicInfo>& topics, const std::string& name) {
  if (!name.empty()) {
    const auto found = std::ranges::find(topics, name, &TopicInfo::name);
    if (found == topics.end()) {
      return absl::InvalidArgumentError(fmt::format("there is no topic {}; {}", name, list_text(topics)));
    }
    if (!found->has_frames) {
      return absl::InvalidArgumentError(fmt::format("topic {} has messages {} ({}), which cannot be read; {}", name,
                                                    found->type, found->encoding, kReadable));
    }
    return *found;
  }
  const auto count = std::ranges::count_if(topics, &TopicInfo::has_frames);
  if (count == 1) return *std::ranges::find_if(topics, &TopicInfo::has_frames);
  return absl::InvalidArgumentError(
      fmt::format("{}; {}",
                  count == 0 ? fmt::format("the recording has no topic that can be read ({})", kReadable)
                             : "several topics can be read, name one with --topic",
                  list_text(topics)));
}

}  // namespace segserve::recording
