// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <deque>
#include <optional>
#include <string>

#include "absl/status/statusor.h"
#include "client/recording/images/image_messages.hpp"
#include "client/recording/message_source.hpp"
#include "client/recording/topic/message_type.hpp"
#include "segserve/client/topic_reader.hpp"

namespace segserve::recording {

/// A message that is kept.
struct KeptMessage {
  MessageType type;
  Message message;  ///< `data` is empty: see `bytes`
  std::string bytes;
  std::int64_t stamp = 0;  ///< of its header, nanoseconds
};

/// A depth image, and the color image nearest in time if there is one.
struct ImagePair {
  KeptMessage depth;
  std::optional<KeptMessage> color;
};

/// Pairs depth images with color images by their stamps. A depth image waits until a color image that is not older has
/// come, but not while more than kMostWaiting others do.
class ImagePairing {
 public:
  static constexpr std::size_t kMostWaiting = 8;
  static constexpr std::size_t kMostBytes = std::size_t{256} << 20U;  ///< of all images that are kept
  /// Images that were taken farther apart than this are no pair.
  static constexpr std::uint64_t kLargestGap = 100'000'000;  // nanoseconds

  explicit ImagePairing(bool with_color) : with_color_(with_color) {}

  void add_depth(KeptMessage depth) { waiting_.push_back(std::move(depth)); }
  void add_color(KeptMessage color);
  /// Tells that no more images will come.
  void finish() { finished_ = true; }
  /// The next pair, in the order of the depth images, if it is known.
  std::optional<ImagePair> take();

 private:
  std::size_t bytes() const;

  bool with_color_;
  bool finished_ = false;
  std::deque<KeptMessage> waiting_;  ///< depth images
  std::deque<KeptMessage> colors_;   ///< the newest ones, oldest first
};

/// The message with its bytes and stamp. The stamp of a damaged message is its log time.
KeptMessage keep_image(const MessageType& type, const Message& message);

/// Makes a CAMERA cloud of a pair by the camera's intrinsics. `is_rectified` tells which of CameraInfo's intrinsics
/// apply. A color image that cannot be used becomes a warning. INVALID_ARGUMENT for a damaged depth image, one of
/// another size than the camera's, and intrinsics that are none; CANCELLED and DEADLINE_EXCEEDED as `stop` says.
/// `frame` gets stamp, frame_id and content.
void read_pair(const ImagePair& pair, const CameraInfo& camera, bool is_rectified,
               const client::TopicReaderOptions& options, const StopToken& stop, client::TopicFrame& frame);

}  // namespace segserve::recording
