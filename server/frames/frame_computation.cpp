#include "server/frames/frame_computation.hpp"

#include <utility>
#include <vector>

#include "proto/wire/cloud_message.hpp"
#include "proto/wire/options_message.hpp"
#include "proto/wire/result_message.hpp"
#include "proto/wire/status_message.hpp"
#include "server/version.hpp"

namespace segserve::server {
namespace {

using Clock = std::chrono::steady_clock;

double milliseconds(Clock::duration duration) { return std::chrono::duration<double, std::milli>(duration).count(); }

}  // namespace

absl::StatusOr<v1::SegmentationResult> process(const Frame& frame, const codec::DecodeLimits& limits,
                                               SegmentationBackend& segmenter, const StopToken& stop) {
  const Clock::time_point started = Clock::now();
  if (const absl::Status status = stop.check(); !status.ok()) return status;
  const absl::StatusOr<wire::DecodedCloud> decoded = wire::decode_cloud(frame.payload, limits, stop);
  if (!decoded.ok()) return decoded.status();
  const Clock::time_point decode_end = Clock::now();

  const CloudView& cloud = decoded->cloud;
  const std::vector<FieldViolation> faults = wire::violations_in_view(frame.request.options, cloud.view);
  if (!faults.empty()) return wire::invalid_fields(faults);
  if (const absl::Status status = stop.check(); !status.ok()) return status;
  absl::StatusOr<Segmentation> segmentation = segmenter.segment(cloud, frame.request.options, stop);
  if (!segmentation.ok()) {
    const bool is_cloud_at_fault = absl::IsInvalidArgument(segmentation.status());  // the options were checked before
    return is_cloud_at_fault ? wire::with_reason(segmentation.status(), v1::ERROR_REASON_INVALID_CLOUD)
                             : segmentation.status();
  }
  if (frame.request.outputs.segments) {
    const absl::Status status = describe(cloud, frame.request.options.threads, stop, *segmentation);
    if (!status.ok()) return status;
  }
  if (const absl::Status status = stop.check(); !status.ok()) return status;

  const Clock::time_point encode_start = Clock::now();
  wire::Result result =
      wire::make_result(*std::move(segmentation), cloud, frame.request.options, decoded->view_rule, kVersion);
  result.timings.queue = milliseconds(started - frame.arrival);
  result.timings.decode = milliseconds(decode_end - started);
  absl::StatusOr<v1::SegmentationResult> message = wire::to_message(result, frame.request.outputs);
  if (message.ok()) {
    const Clock::time_point end = Clock::now();
    wire::set_final_timings(*message, milliseconds(end - encode_start), milliseconds(end - frame.arrival));
  }
  return message;
}

}  // namespace segserve::server
