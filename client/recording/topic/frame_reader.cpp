// SPDX-License-Identifier: Apache-2.0
#include "client/recording/topic/frame_reader.hpp"

#include <fmt/format.h>

#include <utility>

#include "client/recording/topic/parse_message.hpp"
#include "client/recording/topic/topic_list.hpp"
#include "client/recording/topic/topic_view.hpp"
#include "core/base/status_macros.hpp"
#include "core/base/status_text.hpp"
#include "segserve/codec/strided.hpp"

namespace segserve::recording {
namespace {

client::RecordingTime to_time(std::int64_t nanoseconds) {
  return client::RecordingTime(std::chrono::nanoseconds(nanoseconds));
}

absl::StatusOr<codec::LabeledCloud> decode_cloud_message(const PointCloud2& message,
                                                         const client::TopicReaderOptions& options,
                                                         const StopToken& stop) {
  // Unless the view is given, the name of the frame tells it.
  const codec::ReadOptions read{
      .view = options.view.value_or(View::world()), .unit = options.unit, .keep_everything = options.keep_everything};
  ASSIGN_OR_RETURN(auto content, codec::decode_strided(message.layout, message.data, read, options.limits, stop));
  if (!options.view) choose_view(message.header.frame_id, message.has_pose, content);
  return content;
}

std::uint16_t number_not_in(const Definitions& definitions) {
  std::uint16_t number = 0xFFFF;
  while (number > 0 && (definitions.channels.contains(number) || definitions.schemas.contains(number))) --number;
  return number;
}

/// The first camera of a topic.
absl::StatusOr<CameraInfo> first_camera(const std::string& path, const std::string& topic,
                                        const client::TopicReaderOptions& options, const StopToken& stop) {
  ASSIGN_OR_RETURN(const auto source, open_source(path, options.limits));
  while (true) {
    ASSIGN_OR_RETURN(const auto item, source->next(stop));
    if (!item) return absl::InvalidArgumentError(fmt::format("topic {} has no message", topic));
    if (!item->message) continue;
    const Channel& channel = source->definitions().channels.at(item->message->channel);
    const auto type = message_type(channel, source->definitions().schema_of(channel));
    if (channel.topic != topic || !type || type->kind != MessageKind::kCameraInfo) continue;
    return parse_camera_info(type->encoding, item->message->data);
  }
}

}  // namespace

absl::StatusOr<FrameReader> FrameReader::open(const std::string& path, const client::TopicReaderOptions& options,
                                              const StopToken& stop) {
  const auto open = [&]() -> absl::StatusOr<FrameReader> {
    FrameReader reader;
    reader.options_ = options;
    ASSIGN_OR_RETURN(const Contents contents, read_contents(path, options.limits, stop));
    RETURN_IF_ERROR(reader.choose_topics(contents, path, stop));
    ASSIGN_OR_RETURN(reader.source_, open_source(path, options.limits));
    return reader;
  };
  auto reader = open();
  if (!reader.ok() && absl::IsInvalidArgument(reader.status())) return with_prefix(path, reader.status());
  return reader;
}

absl::Status FrameReader::choose_topics(const Contents& contents, const std::string& path, const StopToken& stop) {
  topics_ = topic_list(contents);
  free_number_ = number_not_in(contents.definitions);
  ASSIGN_OR_RETURN(topic_, choose_topic(contents, options_.topic));
  const bool has_images = is_image(type_of_topic(contents, topic_.name)->kind);
  if (!has_images && !(options_.color_topic.empty() && options_.camera_info_topic.empty())) {
    return absl::InvalidArgumentError(
        fmt::format("topic {} has clouds; only images have a color topic and a camera info topic", topic_.name));
  }
  if (!has_images) return absl::OkStatus();
  if (!options_.color_topic.empty()) {
    RETURN_IF_ERROR(check_topic(contents, options_.color_topic, is_image, "topic of images"));
  }
  if (options_.camera_info_topic.empty()) {
    ASSIGN_OR_RETURN(options_.camera_info_topic, camera_info_topic(contents, topic_.name));
  }
  const auto is_camera = [](MessageKind kind) { return kind == MessageKind::kCameraInfo; };
  RETURN_IF_ERROR(check_topic(contents, options_.camera_info_topic, is_camera, "topic of cameras"));
  ASSIGN_OR_RETURN(camera_, first_camera(path, options_.camera_info_topic, options_, stop));
  pairing_.emplace(!options_.color_topic.empty());
  return absl::OkStatus();
}

RecordedFrame FrameReader::read_cloud(const MessageType& type, const Message& message, const StopToken& stop) {
  RecordedFrame recorded{
      .frame = {.index = frames_++, .log_time = to_time(static_cast<std::int64_t>(message.log_time))},
      .type = type,
      .message = message,
      .bytes = std::string(message.data)};
  recorded.message.data = {};
  const auto cloud = parse_cloud(type.encoding, recorded.bytes);
  if (!cloud.ok()) {
    recorded.frame.content = cloud.status();
    return recorded;
  }
  recorded.frame.stamp = to_time(cloud->header.stamp);
  recorded.frame.frame_id = cloud->header.frame_id;
  recorded.frame.content = decode_cloud_message(*cloud, options_, stop);
  return recorded;
}

RecordedFrame FrameReader::read_images(const ImagePair& pair, const StopToken& stop) {
  const Message& message = pair.depth.message;
  RecordedFrame recorded{
      .frame = {.index = frames_++, .log_time = to_time(static_cast<std::int64_t>(message.log_time))},
      .type = pair.depth.type,
      .message = message};
  const bool is_rectified = topic_.name.find("rect") != std::string::npos;
  read_pair(pair, camera_, is_rectified, options_, stop, recorded.frame);
  return recorded;
}

void FrameReader::take_image(const Channel& channel, const MessageType& type, const Message& message) {
  if (channel.topic == options_.camera_info_topic && type.kind == MessageKind::kCameraInfo) {
    // A damaged message leaves the camera as it was.
    if (auto camera = parse_camera_info(type.encoding, message.data); camera.ok()) camera_ = *std::move(camera);
  }
  if (!is_image(type.kind)) return;
  if (channel.topic == topic_.name) pairing_->add_depth(keep_image(type, message));
  if (channel.topic == options_.color_topic) pairing_->add_color(keep_image(type, message));
}

absl::StatusOr<std::optional<RecordedFrame>> FrameReader::next(const OnOther& on_other, const StopToken& stop) {
  while (true) {
    if (const auto pair = pairing_ ? pairing_->take() : std::nullopt) {
      RecordedFrame frame = read_images(*pair, stop);
      RETURN_IF_ERROR(stop.check());
      return frame;
    }
    if (at_end_) return std::nullopt;
    ASSIGN_OR_RETURN(const auto item, source_->next(stop));
    if (!item) {
      at_end_ = true;
      if (pairing_) pairing_->finish();
      continue;
    }
    if (item->message) {
      const Channel& channel = definitions().channels.at(item->message->channel);
      const auto type = message_type(channel, definitions().schema_of(channel));
      if (type && pairing_) take_image(channel, *type, *item->message);
      if (type && !pairing_ && channel.topic == topic_.name && type->kind == MessageKind::kPointCloud2) {
        RecordedFrame frame = read_cloud(*type, *item->message, stop);
        RETURN_IF_ERROR(stop.check());
        return frame;
      }
    }
    if (on_other) RETURN_IF_ERROR(on_other(*item));
  }
}

}  // namespace segserve::recording
