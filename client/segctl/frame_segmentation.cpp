// SPDX-License-Identifier: Apache-2.0
#include "client/segctl/frame_segmentation.hpp"

#include <algorithm>
#include <cstdint>
#include <thread>
#include <utility>

#include "client/calls/local.hpp"
#include "client/segctl/summary.hpp"
#include "core/base/status_macros.hpp"
#include "segserve/client/payload.hpp"
#include "segserve/v1/segmentation_service.pb.h"

namespace segserve::segctl {
namespace {

constexpr std::size_t kFramesInFlight = 4;
/// The credit that the server is asked for, because the largest frame is not known. It gives less if it must.
constexpr std::uint64_t kWantedBytes = std::uint64_t{256} << 20U;

/// A name that every message can carry: at most 256 bytes, and ASCII only.
std::string ascii_name(std::string name) {
  constexpr std::size_t kMostNameBytes = 256;
  name.resize(std::min(name.size(), kMostNameBytes));
  std::ranges::replace_if(
      name, [](char c) { return c < ' ' || c > '~'; }, '?');
  return name;
}

/// The result of a cloud without points.
client::Result empty_result(const codec::LabeledCloud& content, const Options& options) {
  client::Result result;
  result.method = options.method;
  result.view = content.cloud.view;
  return result;
}

absl::StatusOr<client::Result> segment_in_this_process(const codec::LabeledCloud& content,
                                                       const SegmentRequest& request,
                                                       const std::optional<wire::TrackRequest>& tracking) {
  const wire::Outputs outputs{.segments = request.segments};
  const Options options = codec::to_cloud(content.placement, request.options);
  if (!request.codec)
    return client::segment_here(content.cloud, "", options, outputs, StopToken(), std::nullopt, tracking);
  ASSIGN_OR_RETURN(const auto payload, client::cloud_payload(content.cloud, *request.codec));
  return client::segment_here(payload, options, outputs, StopToken(), std::nullopt, tracking);
}

absl::StatusOr<client::Stream> open_stream(const SegmentArguments& arguments, const SegmentRequest& request) {
  ASSIGN_OR_RETURN(const auto client, arguments.server.connect(arguments.fallback_local));
  // Without this, every frame would fail for the same reason.
  const absl::Status reached = client.server_info().status();
  if (!reached.ok() && !(arguments.fallback_local && absl::IsUnavailable(reached))) return reached;
  client::StreamOptions options;
  options.client_name = "segctl segment";
  options.options = request.options;
  options.outputs = {.labels = true, .segments = request.segments};
  options.outputs.compression = answer_compression(request.codec);
  options.codec = request.codec.value_or(wire::CodecOptions{});
  options.fallback_to_local = arguments.fallback_local;
  options.max_in_flight = kFramesInFlight;
  options.max_waiting = kFramesInFlight;
  if (arguments.track.track) options.tracking = arguments.track.options;
  options.wanted_bytes = kWantedBytes;
  ASSIGN_OR_RETURN(options.frame_timeout, arguments.server.timeout());
  return client.open_stream(options);
}

}  // namespace

absl::StatusOr<FrameSegmentation> FrameSegmentation::start(const SegmentArguments& arguments) {
  FrameSegmentation segmentation;
  ASSIGN_OR_RETURN(segmentation.request_, arguments.request());
  segmentation.parallel_ = kFramesInFlight;
  if (arguments.track.track) segmentation.tracking_ = arguments.track.options;
  if (arguments.local) {
    // Each frame needs the tracks of the one before.
    segmentation.parallel_ = arguments.track.track ? 1 : std::max(1U, std::thread::hardware_concurrency());
  } else {
    ASSIGN_OR_RETURN(segmentation.stream_, open_stream(arguments, segmentation.request_));
  }
  return segmentation;
}

absl::Status FrameSegmentation::send(const recording::RecordedFrame& recorded) {
  client::FrameOptions options;
  options.frame_id = ascii_name(recorded.frame.frame_id);
  options.stamp = std::chrono::time_point_cast<std::chrono::system_clock::duration>(recorded.frame.stamp);
  options.traceparent = request_.traceparent;
  const codec::Placement& placement = recorded.frame.content->placement;
  if (!placement.is_identity()) options.options = codec::to_cloud(placement, request_.options);
  return stream_->send(recorded.frame.content->cloud, options).status();
}

void FrameSegmentation::add(recording::RecordedFrame recorded) {
  Waiting& waiting = waiting_.emplace_back(std::move(recorded));
  const absl::StatusOr<codec::LabeledCloud>& content = waiting.recorded.frame.content;
  if (!content.ok()) {
    waiting.result = content.status();
  } else if (content->cloud.size() == 0) {
    waiting.result = empty_result(*content, request_.options);
  } else if (!stream_) {
    // Elements of a deque stay where they are.
    std::optional<wire::TrackRequest> tracking;
    if (tracking_) {
      tracking = {.options = *tracking_, .state = track_state_};
      tracking->options.time = std::chrono::duration<double>(waiting.recorded.frame.stamp.time_since_epoch()).count();
    }
    waiting.local = std::async(std::launch::async, [&content = *content, request = request_, tracking] {
      return segment_in_this_process(content, request, tracking);
    });
  } else if (absl::Status sent = send(waiting.recorded); !sent.ok()) {
    waiting.result = sent;
  }
}

FrameSegmentation::FrameResult FrameSegmentation::result_of(Waiting& waiting) {
  if (waiting.result) return *std::move(waiting.result);
  if (waiting.local.valid()) return waiting.local.get();
  auto outcome = stream_->next();
  if (!outcome) return absl::InternalError("the stream ended without the outcome of a frame");
  if (outcome->result) return *std::move(outcome->result);
  return outcome->status;
}

SegmentedFrame FrameSegmentation::next() {
  Waiting& waiting = waiting_.front();
  FrameResult result = result_of(waiting);
  if (result.ok() && result->tracks) track_state_ = result->tracks->state;
  if (result.ok()) take_file_facts(*waiting.recorded.frame.content, *result);
  SegmentedFrame done{std::move(waiting.recorded), std::move(result)};
  waiting_.pop_front();
  return done;
}

}  // namespace segserve::segctl
