// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "client/recording/message_source.hpp"
#include "client/recording/topic/message_type.hpp"
#include "segserve/client/topic_reader.hpp"

namespace segserve::recording {

/// A frame and the message it was made of.
struct RecordedFrame {
  client::TopicFrame frame = {};
  MessageType type = {};
  Message message = {};    ///< `data` is empty: see `bytes`
  std::string bytes = {};  ///< of the message
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

  /// The next frame; nothing at the end. `on_other` gets everything else on the way, and ends the reading by an error.
  absl::StatusOr<std::optional<RecordedFrame>> next(const OnOther& on_other, const StopToken& stop);

 private:
  RecordedFrame read_frame(const MessageType& type, const Message& message, const StopToken& stop);

  client::TopicReaderOptions options_;
  std::vector<client::TopicInfo> topics_;
  client::TopicInfo topic_;
  std::unique_ptr<MessageSource> source_;
  std::uint64_t frames_ = 0;
};

}  // namespace segserve::recording
