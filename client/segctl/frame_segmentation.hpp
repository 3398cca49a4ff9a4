// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <deque>
#include <future>
#include <optional>
#include <string>

#include "absl/status/statusor.h"
#include "client/recording/topic/frame_reader.hpp"
#include "client/segctl/segment_arguments.hpp"
#include "segserve/client/client.hpp"

namespace segserve::segctl {

/// A frame and its result.
struct SegmentedFrame {
  recording::RecordedFrame recorded;
  absl::StatusOr<client::Result> result;
};

/// Segments frames through a stream or in this process, several at the same time, and gives them back in their order.
class FrameSegmentation {
 public:
  /// Reaches the server unless the frames are segmented in this process.
  static absl::StatusOr<FrameSegmentation> start(const SegmentArguments& arguments);

  /// Whether a frame can be handed over before `next` is called.
  bool has_room() const { return waiting_.size() < parallel_; }
  bool is_empty() const { return waiting_.empty(); }
  void add(recording::RecordedFrame recorded);
  /// Waits for the result of the oldest frame. There must be one.
  SegmentedFrame next();

 private:
  using FrameResult = absl::StatusOr<client::Result>;
  struct Waiting {
    recording::RecordedFrame recorded;
    std::optional<FrameResult> result;  ///< known without segmentation
    std::future<FrameResult> local;     ///< in this process
  };

  absl::Status send(const recording::RecordedFrame& recorded);
  FrameResult result_of(Waiting& waiting);

  SegmentRequest request_;
  std::size_t parallel_ = 1;
  std::optional<TrackOptions> tracking_;
  std::string track_state_;  ///< in this process
  std::optional<client::Stream> stream_;
  std::deque<Waiting> waiting_;
};

}  // namespace segserve::segctl
