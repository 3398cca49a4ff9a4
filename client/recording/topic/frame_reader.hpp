// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "client/recording/message_source.hpp"
#include "client/recording/topic/message_type.hpp"
#include "client/recording/topic/rgbd_frames.hpp"
#include "segserve/client/topic_reader.hpp"

namespace segserve::recording {

/// A frame and the message it was made of.
struct RecordedFrame {
  client::TopicFrame frame = {};
  MessageType type = {};
  Message message = {};    ///< that of the cloud, or of the depth image; `data` is empty: see `bytes`
  std::string bytes = {};  ///< of a cloud's message; empty for images
};

/// Reads a recording as client::TopicReader does, and hands on what else there is in it.
class FrameReader {
 public:
  using OnOther = std::function<absl::Status(const Item&)>;

  static absl::StatusOr<FrameReader> open(const std::string& path, const client::TopicReaderOptions& options,
                                          const StopToken& stop);

  const std::vector<client::TopicInfo>& topics() const { return topics_; }
  const client::TopicInfo& topic() const { return topic_; }
  const std::string& profile() const { return source_->profile(); }
  const Definitions& definitions() const { return source_->definitions(); }
  const std::vector<codec::Warning>& warnings() const { return source_->warnings(); }
  /// Whether frames are made of images, so that their messages are no clouds.
  bool reads_images() const { return pairing_.has_value(); }
  /// A number that no schema and no channel of the recording has.
  std::uint16_t free_number() const { return free_number_; }

  /// The next frame; nothing at the end. `on_other` gets everything else on the way, images that frames are made of
  /// included, and ends the reading by an error.
  absl::StatusOr<std::optional<RecordedFrame>> next(const OnOther& on_other, const StopToken& stop);

 private:
  absl::Status choose_topics(const Contents& contents, const std::string& path, const StopToken& stop);
  RecordedFrame read_cloud(const MessageType& type, const Message& message, const StopToken& stop);
  RecordedFrame read_images(const ImagePair& pair, const StopToken& stop);
  /// Keeps an image, or takes a camera.
  void take_image(const Channel& channel, const MessageType& type, const Message& message);

  client::TopicReaderOptions options_;
  std::vector<client::TopicInfo> topics_;
  client::TopicInfo topic_;
  std::uint16_t free_number_ = 0;
  std::unique_ptr<MessageSource> source_;
  std::uint64_t frames_ = 0;

  std::optional<ImagePairing> pairing_;  ///< of a topic of images
  CameraInfo camera_;                    ///< the newest one
  bool at_end_ = false;
};

}  // namespace segserve::recording
