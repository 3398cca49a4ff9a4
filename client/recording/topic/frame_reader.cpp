// SPDX-License-Identifier: Apache-2.0
#include "client/recording/topic/frame_reader.hpp"

#include <fmt/format.h>

#include <utility>

#include "client/recording/ros/point_cloud2.hpp"
#include "client/recording/topic/topic_list.hpp"
#include "client/recording/topic/view_choice.hpp"
#include "core/base/status_macros.hpp"
#include "core/base/status_text.hpp"
#include "segserve/codec/strided.hpp"

namespace segserve::recording {
namespace {

client::RecordingTime to_time(std::int64_t nanoseconds) {
  return client::RecordingTime(std::chrono::nanoseconds(nanoseconds));
}

absl::StatusOr<codec::LabeledCloud> read_cloud(const PointCloud2& message, const client::TopicReaderOptions& options,
                                               const StopToken& stop) {
  codec::LabeledCloud content;
  ASSIGN_OR_RETURN(content.cloud,
                   codec::decode_strided(message.layout, message.data, View::world(), options.limits, stop));
  choose_view(message.header.frame_id, options.view, content);
  return content;
}

}  // namespace

absl::StatusOr<FrameReader> FrameReader::open(const std::string& path, const client::TopicReaderOptions& options,
                                              const StopToken& stop) {
  const auto open = [&]() -> absl::StatusOr<FrameReader> {
    FrameReader reader;
    reader.options_ = options;
    ASSIGN_OR_RETURN(const Contents contents, read_contents(path, options.limits, stop));
    reader.topics_ = topic_list(contents);
    ASSIGN_OR_RETURN(reader.topic_, choose_topic(reader.topics_, options.topic));
    ASSIGN_OR_RETURN(reader.source_, open_source(path, options.limits));
    return reader;
  };
  auto reader = open();
  if (!reader.ok() && absl::IsInvalidArgument(reader.status())) return with_prefix(path, reader.status());
  return reader;
}

RecordedFrame FrameReader::read_frame(const MessageType& type, const Message& message, const StopToken& stop) {
  RecordedFrame recorded{
      .frame = {.index = frames_++, .log_time = to_time(static_cast<std::int64_t>(message.log_time))},
      .type = type,
      .message = message,
      .bytes = std::string(message.data)};
  recorded.message.data = {};
  const auto cloud = parse_point_cloud2(recorded.bytes, type.wire);
  if (!cloud.ok()) {
    recorded.frame.content = cloud.status();
    return recorded;
  }
  recorded.frame.stamp = to_time(cloud->header.stamp);
  recorded.frame.frame_id = cloud->header.frame_id;
  recorded.frame.content = read_cloud(*cloud, options_, stop);
  return recorded;
}

absl::StatusOr<std::optional<RecordedFrame>> FrameReader::next(const OnOther& on_other, const StopToken& stop) {
  while (true) {
    ASSIGN_OR_RETURN(const auto item, source_->next(stop));
    if (!item) return std::nullopt;
    if (item->message) {
      const Channel& channel = definitions().channels.at(item->message->channel);
      const auto type = message_type(channel, definitions().schema_of(channel));
      if (channel.topic == topic_.name && type && has_frames(type->kind)) {
        RecordedFrame frame = read_frame(*type, *item->message, stop);
        RETURN_IF_ERROR(stop.check());
        return frame;
      }
    }
    if (on_other) RETURN_IF_ERROR(on_other(*item));
  }
}

}  // namespace segserve::recording
