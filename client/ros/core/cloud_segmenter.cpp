// SPDX-License-Identifier: Apache-2.0
#include "client/ros/core/cloud_segmenter.hpp"

#include <chrono>
#include <utility>

#include "client/recording/ros/point_cloud2.hpp"
#include "client/recording/topic/topic_view.hpp"
#include "core/base/status_macros.hpp"
#include "fmt/format.h"
#include "segserve/client/client.hpp"
#include "segserve/client/stream_options.hpp"
#include "segserve/codec/labeled_cloud.hpp"

namespace segserve::ros {
namespace {

client::StreamOptions stream_options(const NodeOptions& options) {
  client::StreamOptions stream;
  stream.client_name = "segserve ROS node";
  stream.options = options.segmentation;
  stream.outputs = {.labels = true, .segments = true};
  stream.when_behind = client::WhenBehind::kDropOldest;
  stream.max_in_flight = options.max_in_flight;
  stream.max_waiting = 1;
  stream.fallback_to_local = options.fallback_to_local;
  if (options.track) stream.tracking.emplace();
  return stream;
}

/// The points of a cloud, in the view that was given or that the frame and the points make plain.
absl::StatusOr<codec::LabeledCloud> decode(const IncomingCloud& cloud, const std::optional<View>& view) {
  const codec::ReadOptions options{.view = view.value_or(View::world())};
  ASSIGN_OR_RETURN(auto content, codec::decode_strided(cloud.layout, cloud.data, options, {}));
  if (!view) recording::choose_view(cloud.frame_id, false, content);
  return content;
}

std::chrono::system_clock::time_point time_of(const Stamp& stamp) {
  const auto since = std::chrono::seconds(stamp.seconds) + std::chrono::nanoseconds(stamp.nanoseconds);
  return std::chrono::system_clock::time_point(std::chrono::duration_cast<std::chrono::system_clock::duration>(since));
}

/// A name that every frame can carry: at most 256 bytes, ASCII only.
std::string ascii_frame_id(std::string name) {
  constexpr std::size_t kMostBytes = 256;
  if (name.size() > kMostBytes) name.resize(kMostBytes);
  for (char& c : name) c = c < ' ' || c > '~' ? '?' : c;
  return name;
}

}  // namespace

absl::StatusOr<std::unique_ptr<CloudSegmenter>> CloudSegmenter::start(const NodeOptions& options, Handlers handlers) {
  ASSIGN_OR_RETURN(const auto client, client::Client::connect(options.client));
  std::unique_ptr<CloudSegmenter> segmenter(new CloudSegmenter(options, std::move(handlers)));
  client::StreamOptions stream = stream_options(options);
  stream.on_outcome = [raw = segmenter.get()](const client::Outcome& outcome) { raw->finish(outcome); };
  ASSIGN_OR_RETURN(segmenter->stream_, client.open_stream(std::move(stream)));
  return segmenter;
}

CloudSegmenter::CloudSegmenter(NodeOptions options, Handlers handlers)
    : options_(std::move(options)), handlers_(std::move(handlers)) {}

CloudSegmenter::~CloudSegmenter() { stream_.reset(); }

absl::Status CloudSegmenter::add(IncomingCloud cloud) {
  RETURN_IF_ERROR(codec::check_layout(cloud.layout, {}));
  if (cloud.data.size() != cloud.layout.bytes()) {
    return absl::InvalidArgumentError(fmt::format("the cloud has {} bytes, but its {} rows have {}", cloud.data.size(),
                                                  cloud.layout.height, cloud.layout.bytes()));
  }
  if (cloud.layout.width == 0 || cloud.layout.height == 0) return publish(cloud, {}, {});
  ASSIGN_OR_RETURN(codec::LabeledCloud content, decode(cloud, options_.view));
  client::FrameOptions frame;
  frame.frame_id = ascii_frame_id(cloud.frame_id);
  frame.stamp = time_of(cloud.stamp);
  frame.time_to_live = options_.time_to_live;
  if (!content.placement.is_identity()) frame.options = codec::to_cloud(content.placement, options_.segmentation);
  auto points = std::make_shared<const Cloud>(std::move(content.cloud));
  // The outcome may come before send() has returned; it then waits for the lock.
  const MutexLock lock(mutex_);
  ASSIGN_OR_RETURN(const std::uint64_t sequence, stream_->send(std::move(points), std::move(frame)));
  waiting_.emplace(sequence, Waiting{std::move(cloud), content.placement});
  return absl::OkStatus();
}

void CloudSegmenter::finish(const client::Outcome& outcome) {
  std::optional<Waiting> waiting;
  {
    const MutexLock lock(mutex_);
    auto node = waiting_.extract(outcome.sequence);
    if (node.empty()) return;
    waiting = std::move(node.mapped());
  }
  absl::Status status = outcome.status;
  if (outcome.kind == client::OutcomeKind::kResult) {
    wire::Result result = *outcome.result;
    codec::to_file(waiting->placement, result.segmentation);
    status = publish(waiting->cloud, published_labels(result), detections_of(result, options_.min_points));
  }
  const bool is_late = outcome.kind == client::OutcomeKind::kDropped || outcome.kind == client::OutcomeKind::kExpired ||
                       outcome.kind == client::OutcomeKind::kCancelled;
  {
    const MutexLock lock(mutex_);
    ++(status.ok() ? counts_.segmented : is_late ? counts_.dropped : counts_.failed);
  }
  if (!status.ok() && !is_late && handlers_.on_warning) {
    handlers_.on_warning(fmt::format("a cloud in the frame '{}' was not segmented: {}", waiting->cloud.frame_id,
                                     std::string(status.message())));
  }
}

absl::Status CloudSegmenter::publish(const IncomingCloud& cloud, const std::vector<std::uint32_t>& labels,
                                     std::vector<Detection> detections) const {
  ASSIGN_OR_RETURN(auto labeled, recording::add_labels(cloud.layout, cloud.data, labels));
  handlers_.on_segmented({.frame_id = cloud.frame_id,
                          .stamp = cloud.stamp,
                          .layout = std::move(labeled.layout),
                          .data = std::move(labeled.data),
                          .is_dense = cloud.is_dense,
                          .detections = std::move(detections)});
  return absl::OkStatus();
}

SegmenterCounts CloudSegmenter::counts() const {
  const MutexLock lock(mutex_);
  return counts_;
}

}  // namespace segserve::ros
