// SPDX-License-Identifier: Apache-2.0
#include "server/frames/frame_computation.hpp"

#include <chrono>
#include <string>
#include <utility>

#include "core/base/status_macros.hpp"
#include "proto/wire/cloud_message.hpp"
#include "proto/wire/options_message.hpp"
#include "proto/wire/result_message.hpp"
#include "proto/wire/status_message.hpp"
#include "server/version.hpp"

namespace segserve::server {
namespace {

using Clock = std::chrono::steady_clock;

double milliseconds(Clock::duration duration) { return std::chrono::duration<double, std::milli>(duration).count(); }

absl::StatusOr<Segmentation> segment_decoded(const CloudView& cloud, const FrameSettings& settings,
                                             const StopToken& stop, SegmentationBackend& backend) {
  RETURN_IF_ERROR(wire::invalid_fields(wire::violations_in_view(settings.options, cloud.view)));
  RETURN_IF_ERROR(stop.check());
  absl::StatusOr<Segmentation> segmentation = backend.segment(cloud, settings.options, stop);
  // The options were checked before, so an invalid argument can only be the cloud.
  if (absl::IsInvalidArgument(segmentation.status())) {
    return wire::with_reason(segmentation.status(), wire::ErrorReason::kInvalidCloud);
  }
  RETURN_IF_ERROR(segmentation.status());
  if (settings.outputs.segments) RETURN_IF_ERROR(describe(cloud, settings.options.threads, stop, *segmentation));
  RETURN_IF_ERROR(stop.check());
  return segmentation;
}

}  // namespace

absl::StatusOr<v1::SegmentationResult> compute_frame(const v1::Cloud& payload, const FrameSettings& settings,
                                                     const std::atomic<bool>& cancelled, SegmentationBackend& backend) {
  const StopToken stop(&cancelled, settings.deadline);
  const Clock::time_point decode_start = Clock::now();
  RETURN_IF_ERROR(stop.check());
  ASSIGN_OR_RETURN(const wire::DecodedCloud decoded, wire::decode_cloud(payload, settings.decode_limits, stop));
  const Clock::time_point decode_end = Clock::now();

  ASSIGN_OR_RETURN(Segmentation segmentation, segment_decoded(decoded.cloud, settings, stop, backend));

  const Clock::time_point encode_start = Clock::now();
  wire::Result result =
      wire::make_result(std::move(segmentation), decoded.cloud, settings.options, decoded.view_rule, kVersion);
  result.timings.queue = milliseconds(decode_start - settings.arrival);
  result.timings.decode = milliseconds(decode_end - decode_start);
  ASSIGN_OR_RETURN(v1::SegmentationResult message, wire::to_message(result, settings.outputs));
  const Clock::time_point encode_end = Clock::now();
  wire::set_final_timings(message, milliseconds(encode_end - encode_start),
                          milliseconds(encode_end - settings.arrival));
  return message;
}

}  // namespace segserve::server
