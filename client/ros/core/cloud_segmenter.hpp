// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "absl/base/thread_annotations.h"
#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "client/ros/core/detection.hpp"
#include "client/ros/core/node_options.hpp"
#include "core/base/mutex.hpp"
#include "segserve/client/stream.hpp"
#include "segserve/codec/placement.hpp"
#include "segserve/codec/strided.hpp"

// The part that the nodes of ROS 1 and ROS 2 share. It knows nothing of ROS.
namespace segserve::ros {

/// When a cloud was taken, as in std_msgs/Header.
struct Stamp {
  std::int64_t seconds = 0;
  std::uint32_t nanoseconds = 0;
  bool operator==(const Stamp&) const = default;
};

/// sensor_msgs/PointCloud2 as it came.
struct IncomingCloud {
  std::string frame_id;
  Stamp stamp;
  codec::StridedLayout layout;
  std::string_view data;  ///< layout.bytes() bytes
  bool is_dense = false;
  std::shared_ptr<const void> owner;  ///< keeps `data` alive
};

/// A labeled cloud and its detections, which a node publishes.
struct SegmentedCloud {
  std::string frame_id;
  Stamp stamp;
  codec::StridedLayout layout;  ///< that of the cloud and the field `label`, UINT32 (recording::add_labels)
  std::string data;             ///< layout.bytes() bytes
  bool is_dense = false;
  std::vector<Detection> detections;  ///< in the coordinates of the cloud
};

/// How the clouds ended that add() took.
struct SegmenterCounts {
  std::uint64_t segmented = 0;
  std::uint64_t dropped = 0;  ///< made way for newer ones, or became too old
  std::uint64_t failed = 0;
};

/// Segments clouds through the stream of a segserve::client. It is never behind: of the clouds that wait only the
/// newest one is kept.
class CloudSegmenter {
 public:
  struct Handlers {
    std::function<void(const SegmentedCloud&)> on_segmented;  ///< in the order of the clouds
    std::function<void(const std::string&)> on_warning;       ///< a sentence for people
  };

  /// Does not wait for a server. The handlers are called on a thread of the stream, one at a time, and must not destroy
  /// the segmenter. INVALID_ARGUMENT for options that make no sense.
  static absl::StatusOr<std::unique_ptr<CloudSegmenter>> start(const NodeOptions& options, Handlers handlers);
  /// Waits for a handler that runs. No handler is called after that.
  ~CloudSegmenter();
  CloudSegmenter(const CloudSegmenter&) = delete;
  CloudSegmenter& operator=(const CloudSegmenter&) = delete;

  /// Hands a cloud over; never waits for a server. A cloud without points is segmented at once, on this thread.
  /// INVALID_ARGUMENT if the layout is wrong or does not fit the data; else an error for which no server will ever take
  /// a cloud of this stream.
  absl::Status add(IncomingCloud cloud);

  SegmenterCounts counts() const;

 private:
  struct Waiting {
    IncomingCloud cloud;
    codec::Placement placement;
  };

  CloudSegmenter(NodeOptions options, Handlers handlers);
  void finish(const client::Outcome& outcome);
  absl::Status publish(const IncomingCloud& cloud, const std::vector<std::uint32_t>& labels,
                       std::vector<Detection> detections) const;

  const NodeOptions options_;
  const Handlers handlers_;
  mutable Mutex mutex_;
  std::map<std::uint64_t, Waiting> waiting_ ABSL_GUARDED_BY(mutex_);  // by sequence
  SegmenterCounts counts_ ABSL_GUARDED_BY(mutex_);
  std::optional<client::Stream> stream_;
};

}  // namespace segserve::ros
