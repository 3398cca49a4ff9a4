// SPDX-License-Identifier: Apache-2.0
#include "server/frames/frame_computation.hpp"

#include <algorithm>
#include <chrono>
#include <optional>
#include <string>
#include <utility>

#include "absl/strings/numbers.h"
#include "core/base/status_macros.hpp"
#include "fmt/format.h"
#include "proto/wire/cloud_message.hpp"
#include "proto/wire/options_message.hpp"
#include "proto/wire/prompts_message.hpp"
#include "proto/wire/result_message.hpp"
#include "proto/wire/status_message.hpp"
#include "proto/wire/track_message.hpp"
#include "server/version.hpp"

namespace segserve::server {
namespace {

using Clock = std::chrono::steady_clock;

std::uint64_t decoded_bytes(const CloudView& cloud) {
  return cloud.x.size_bytes() + cloud.y.size_bytes() + cloud.z.size_bytes() + cloud.rgb.size_bytes();
}

double milliseconds(Clock::duration duration) { return std::chrono::duration<double, std::milli>(duration).count(); }

/// The labels of what was selected, in core and encoded.
constexpr std::uint64_t kSelectionBytesPerPoint = 6;

/// The ids of the segments come before their statistics, because the segments may become others. What this needs fits
/// into the memory that the segmentation had, most of which is free again by then.
absl::StatusOr<Segmentation> segment_decoded(const wire::DecodedCloud& decoded, const FrameSettings& settings,
                                             const StopToken& stop, SegmentationBackend& backend, FrameMemory& memory,
                                             std::optional<wire::Tracks>& tracks) {
  const CloudView& cloud = decoded.cloud;
  const Options options = codec::to_cloud(decoded.placement, settings.options);
  RETURN_IF_ERROR(memory.voxelize(cloud.size()));
  RETURN_IF_ERROR(wire::invalid_fields(wire::violations_in_view(options, cloud.view)));
  RETURN_IF_ERROR(stop.check());
  const std::uint64_t bytes_per_point =
      settings.answer_bytes_per_point + (settings.prompts ? kSelectionBytesPerPoint : 0);
  absl::StatusOr<Segmentation> segmentation = backend.segment(cloud, options, stop, [&](FrameSize size) {
    size.workspace_bytes += bytes_per_point * size.points;
    return memory.segment(size);
  });
  // The options were checked before, so an invalid argument can only be the cloud.
  if (absl::IsInvalidArgument(segmentation.status())) {
    return wire::with_reason(segmentation.status(), wire::ErrorReason::kInvalidCloud);
  }
  RETURN_IF_ERROR(segmentation.status());
  if (settings.tracking) {
    ASSIGN_OR_RETURN(tracks, wire::follow(*settings.tracking, cloud.view, stop, *segmentation));
  }
  if (settings.outputs.segments) RETURN_IF_ERROR(describe(cloud, settings.options.threads, stop, *segmentation));
  RETURN_IF_ERROR(stop.check());
  return segmentation;
}

/// The limit `name` that a payload exceeded, and what it would take; nullopt if the status is another one.
std::optional<std::uint64_t> excess(const absl::Status& status, const std::string& name) {
  const wire::ErrorDetails details = wire::details_of(status);
  const auto limit = details.metadata.find("limit"), actual = details.metadata.find("actual");
  if (details.reason != wire::ErrorReason::kLimitExceeded || limit == details.metadata.end() ||
      actual == details.metadata.end() || limit->second != name) {
    return std::nullopt;
  }
  std::uint64_t value = 0;
  return absl::SimpleAtoi(actual->second, &value) ? std::optional(value) : std::nullopt;
}

/// The limit to try after `tried`, which was exceeded by a payload that needs at least `needed`. It grows by a factor,
/// because the payload may not tell more than the first byte beyond the limit, and the payload is decoded anew for
/// each: all attempts together cost a few times the last one. It takes no more than what fits unless more is needed,
/// which the memory then refuses.
std::uint64_t next_limit(std::uint64_t tried, std::uint64_t needed, std::uint64_t fitting) {
  const std::uint64_t larger = tried <= fitting / 4 ? 2 * tried : tried + tried / 2;
  return std::max(needed, std::min(larger, fitting));
}

/// Decodes within the memory that it has leased. A payload may be larger than it seemed, such as a compressed PCD file
/// of which the request does not tell the number of points: it is decoded again with what it turned out to need, or
/// with more if that fits, so that few attempts are needed.
absl::StatusOr<wire::DecodedCloud> decode_within(const DecodePayload& decode, const FrameSettings& settings,
                                                 const StopToken& stop, FrameMemory& memory) {
  constexpr std::uint64_t kScratchPerPoint = 32, kBytesPerPoint = 48, kLeastPoints = 4096;
  const codec::DecodeLimits& most = settings.decode_limits;
  codec::DecodeLimits limits = most;
  limits.max_points = std::min(most.max_points, std::max(kLeastPoints, settings.estimated_points));
  limits.max_bytes = std::min(most.max_bytes, std::max(memory.bytes(), kScratchPerPoint * limits.max_points));
  while (true) {
    RETURN_IF_ERROR(memory.decode(limits.max_points, limits.max_bytes));
    absl::StatusOr<wire::DecodedCloud> decoded = decode(limits, stop);
    if (decoded.ok()) return decoded;
    const auto points = excess(decoded.status(), "max_points"), bytes = excess(decoded.status(), "max_decoded_bytes");
    if (points && limits.max_points < most.max_points) {
      const std::uint64_t fitting = memory.most_scratch_bytes(0) / kBytesPerPoint;
      limits.max_points = std::min(most.max_points, next_limit(limits.max_points, *points, fitting));
      limits.max_bytes = std::min(most.max_bytes, std::max(limits.max_bytes, kScratchPerPoint * limits.max_points));
    } else if (bytes && limits.max_bytes < most.max_bytes) {
      const std::uint64_t fitting = memory.most_scratch_bytes(limits.max_points);
      limits.max_bytes = std::min(most.max_bytes, next_limit(limits.max_bytes, *bytes, fitting));
    } else {
      return decoded;
    }
  }
}

/// The status of a frame that was stopped because it took its maximum time.
absl::Status took_too_long(std::chrono::milliseconds max_time) {
  return wire::with_details(
      absl::ResourceExhaustedError(
          fmt::format("the computation of the frame takes longer than max_frame_seconds = {:g}; a larger "
                      "voxel_resolution takes less time",
                      std::chrono::duration<double>(max_time).count())),
      {.reason = wire::ErrorReason::kLimitExceeded,
       .metadata = {{"limit", "max_frame_seconds"},
                    {"allowed", fmt::format("{:g}", std::chrono::duration<double>(max_time).count())}}});
}

absl::Status compute_until(const DecodePayload& decode, const EncodeResult& encode, const FrameSettings& settings,
                           const StopToken& stop, SegmentationBackend& backend, FrameMemory& memory, FrameWork& work) {
  const Clock::time_point decode_start = *(work.started = Clock::now());
  RETURN_IF_ERROR(stop.check());
  ASSIGN_OR_RETURN(wire::DecodedCloud decoded, decode_within(decode, settings, stop, memory));
  const Clock::time_point decode_end = *(work.decoded = Clock::now());
  work.points = decoded.cloud->size();
  work.decoded_bytes = decoded_bytes(decoded.cloud);

  std::optional<wire::Tracks> tracks;
  ASSIGN_OR_RETURN(Segmentation segmentation, segment_decoded(decoded, settings, stop, backend, memory, tracks));

  ASSIGN_OR_RETURN(auto selection, wire::select_by_prompts(decoded.cloud, decoded.placement, segmentation,
                                                           settings.options, settings.outputs, settings.prompts, stop));

  const Clock::time_point encode_start = *(work.segmented = Clock::now());
  work.stages = segmentation.timings;
  work.voxels = segmentation.voxels;
  work.segments = segmentation.segments;
  wire::Result result =
      wire::make_result(std::move(segmentation), decoded.cloud, settings.options, decoded.view_rule, kVersion);
  result.selection = std::move(selection);
  wire::take_payload_facts(decoded.placement, decoded.warnings, result);
  result.tracks = std::move(tracks);
  work.supervoxels = result.supervoxels;
  result.timings.queue = milliseconds(decode_start - settings.arrival);
  result.timings.decode = milliseconds(decode_end - decode_start);
  result.timings.total = milliseconds(encode_start - settings.arrival);
  ASSIGN_OR_RETURN(const std::uint64_t bytes, encode(result, decoded.cloud));
  work.encoded = Clock::now();
  memory.keep_result(bytes);
  return absl::OkStatus();
}

}  // namespace

absl::Status compute_frame(const DecodePayload& decode, const EncodeResult& encode, const FrameSettings& settings,
                           const std::atomic<bool>& cancelled, SegmentationBackend& backend, FrameMemory& memory,
                           FrameWork& work) {
  const Clock::time_point latest = Clock::now() + settings.max_time;
  const Clock::time_point end = std::min(latest, settings.deadline.value_or(latest));
  const absl::Status status =
      compute_until(decode, encode, settings, StopToken(&cancelled, end), backend, memory, work);
  return absl::IsDeadlineExceeded(status) && end == latest ? took_too_long(settings.max_time) : status;
}

absl::StatusOr<v1::SegmentationResult> compute_frame(const v1::Cloud& payload, const FrameSettings& settings,
                                                     const std::atomic<bool>& cancelled, SegmentationBackend& backend,
                                                     FrameMemory& memory, FrameWork& work) {
  const DecodePayload decode = [&payload](const codec::DecodeLimits& limits, const StopToken& stop) {
    return wire::decode_cloud(payload, limits, stop);
  };
  v1::SegmentationResult message;
  const EncodeResult encode = [&](const wire::Result& result, const CloudView&) -> absl::StatusOr<std::uint64_t> {
    const Clock::time_point start = Clock::now();
    ASSIGN_OR_RETURN(message, wire::to_message(result, settings.outputs));
    const Clock::time_point done = Clock::now();
    wire::set_final_timings(message, milliseconds(done - start), milliseconds(done - settings.arrival));
    return message.ByteSizeLong();
  };
  RETURN_IF_ERROR(compute_frame(decode, encode, settings, cancelled, backend, memory, work));
  return message;
}

}  // namespace segserve::server
