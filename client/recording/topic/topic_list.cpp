// SPDX-License-Identifier: Apache-2.0
#include "client/recording/topic/topic_list.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <map>

#include "core/base/status_macros.hpp"

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

constexpr const char* kReadable =
    "PointCloud2, and depth in Image and CompressedImage, of ROS and of Foxglove can be read";

/// Advises how to record the clouds of a topic that cannot be read. The text is empty if no way is known.
std::string_view advice_on(const TopicInfo& topic) {
  struct Advice {
    std::string_view part, text;  ///< part of the type's name
  };
  constexpr std::string_view kPackets = "the LiDAR's driver makes PointCloud2 of its packets; record that topic";
  constexpr std::array<Advice, 7> kAdvice{
      {{"CompressedPointCloud", "compressed clouds are not read; record the topic with PointCloud2"},
       {"livox_ros_driver", "the Livox driver publishes PointCloud2 with xfer_format 0; record that topic"},
       {"VelodyneScan", kPackets},
       {"VelodynePacket", kPackets},
       {"PacketMsg", kPackets},
       {"Packets", kPackets},
       {"LaserScan", "a scan within a plane is no cloud"}}};
  if (topic.type.ends_with("/PointCloud")) return "PointCloud is older than PointCloud2; record that one";
  if (topic.encoding == "json" && topic.type.find("PointCloud") != std::string::npos) {
    return "messages in JSON are not read; record them as protobuf, CDR or ROS 1";
  }
  const auto* const found = std::ranges::find_if(
      kAdvice, [&topic](const Advice& advice) { return topic.type.find(advice.part) != std::string::npos; });
  return found == kAdvice.end() ? std::string_view() : found->text;
}

/// The advice on the first topic that has one, in front of which a separator stands.
std::string advice_text(const std::vector<TopicInfo>& topics) {
  for (const TopicInfo& topic : topics) {
    if (const std::string_view advice = advice_on(topic); !topic.has_frames && !advice.empty()) {
      return fmt::format("; {}: {}", topic.name, advice);
    }
  }
  return "";
}

/// The namespace of a topic of images: that of "/camera/depth/image_raw/compressed" is "/camera/depth".
std::string namespace_of(std::string topic) {
  const auto cut = [&topic] { topic.resize(std::min(topic.size(), topic.rfind('/'))); };
  if (topic.ends_with("/compressed") || topic.ends_with("/compressedDepth")) cut();
  cut();
  return topic;
}

bool is_depth_name(std::string_view name) { return name.find("depth") != std::string_view::npos; }

}  // namespace

std::optional<MessageType> type_of_topic(const Contents& contents, const std::string& name) {
  for (const auto& [number, channel] : contents.definitions.channels) {
    if (channel.topic == name) return message_type(channel, contents.definitions.schema_of(channel));
  }
  return std::nullopt;
}

std::vector<TopicInfo> topic_list(const Contents& contents) {
  std::map<std::string, TopicInfo> topics;
  for (const auto& [number, channel] : contents.definitions.channels) {
    const auto [entry, is_new] = topics.try_emplace(channel.topic);
    TopicInfo& topic = entry->second;
    if (is_new) {
      const Schema& schema = contents.definitions.schema_of(channel);
      const auto type = message_type(channel, schema);
      const bool has_frames =
          type && (type->kind == MessageKind::kPointCloud2 || (is_image(type->kind) && is_depth_name(channel.topic)));
      topic = {channel.topic, schema.name, channel.message_encoding, 0, has_frames};
    }
    if (const auto count = contents.messages.find(number); count != contents.messages.end()) {
      topic.messages += count->second;
    }
  }
  std::vector<TopicInfo> list;
  list.reserve(topics.size());
  for (auto& [name, topic] : topics) list.push_back(std::move(topic));
  return list;
}

absl::Status check_topic(const Contents& contents, const std::string& name, bool (*is_right)(MessageKind),
                         std::string_view what) {
  const std::vector<TopicInfo> topics = topic_list(contents);
  const auto found = std::ranges::find(topics, name, &TopicInfo::name);
  if (found == topics.end()) {
    return absl::InvalidArgumentError(fmt::format("there is no topic {}; {}", name, list_text(topics)));
  }
  const auto type = type_of_topic(contents, name);
  if (type && is_right(type->kind)) return absl::OkStatus();
  return absl::InvalidArgumentError(fmt::format("topic {} has messages {} ({}): it is no {}; {}", name,
                                                found->type.empty() ? "without a schema" : found->type, found->encoding,
                                                what, list_text(topics)) +
                                    advice_text({*found}));
}

absl::StatusOr<TopicInfo> choose_topic(const Contents& contents, const std::string& name) {
  const std::vector<TopicInfo> topics = topic_list(contents);
  if (!name.empty()) {
    const auto can_be_read = [](MessageKind kind) { return kind == MessageKind::kPointCloud2 || is_image(kind); };
    RETURN_IF_ERROR(check_topic(contents, name, can_be_read, fmt::format("topic that can be read ({})", kReadable)));
    return *std::ranges::find(topics, name, &TopicInfo::name);
  }
  std::vector<TopicInfo> clouds;
  std::vector<TopicInfo> images;
  for (const TopicInfo& topic : topics) {
    if (!topic.has_frames) continue;
    const bool is_cloud = type_of_topic(contents, topic.name)->kind == MessageKind::kPointCloud2;
    (is_cloud ? clouds : images).push_back(topic);
  }
  const std::vector<TopicInfo>& choice = clouds.empty() ? images : clouds;
  if (choice.size() == 1) return choice.front();
  const std::string fault = choice.empty() ? fmt::format("the recording has no topic that can be read ({})", kReadable)
                                           : "several topics can be read, name one (--topic)";
  return absl::InvalidArgumentError(
      fmt::format("{}; {}{}", fault, list_text(topics), choice.empty() ? advice_text(topics) : ""));
}

absl::StatusOr<std::string> camera_info_topic(const Contents& contents, const std::string& images) {
  const std::string prefix = namespace_of(images) + "/";
  std::vector<std::string> found;
  for (const TopicInfo& topic : topic_list(contents)) {
    const auto type = type_of_topic(contents, topic.name);
    if (!type || type->kind != MessageKind::kCameraInfo) continue;
    if (topic.name == prefix + "camera_info") return topic.name;
    if (topic.name.starts_with(prefix)) found.push_back(topic.name);
  }
  if (found.size() == 1) return found.front();
  return absl::InvalidArgumentError(
      fmt::format("there is no topic {}camera_info with the camera of {}, name one (--camera-info-topic); {}", prefix,
                  images, list_text(topic_list(contents))));
}

}  // namespace segserve::recording
