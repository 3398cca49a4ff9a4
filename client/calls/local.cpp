#include "client/calls/local.hpp"

#include <chrono>
#include <utility>

#include "segserve/segment.hpp"

namespace segserve::client {

absl::StatusOr<wire::Result> segment_here(const CloudView& cloud, const std::string& view_rule, const Options& options,
                                          const wire::Outputs& outputs, const StopToken& stop) {
  auto segmentation = segment(cloud, options, stop);
  if (!segmentation.ok()) return segmentation.status();
  if (outputs.segments) {
    const absl::Status status = describe(cloud, options.threads, stop, *segmentation);
    if (!status.ok()) return status;
  }
  const double total = segmentation->timings.total;
  wire::Result result = wire::make_result(*std::move(segmentation), cloud, options, view_rule, SEGSERVE_VERSION);
  result.timings.total = total;
  result.in_this_process = true;
  return result;
}

absl::StatusOr<wire::Result> segment_here(const Payload& payload, const Options& options, const wire::Outputs& outputs,
                                          const StopToken& stop) {
  const auto start = std::chrono::steady_clock::now();
  const auto scene = decode(payload, stop);
  if (!scene.ok()) return scene.status();
  const double decode_ms = std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - start).count();
  auto result = segment_here(scene->cloud, scene->view_rule, options, outputs, stop);
  if (!result.ok()) return result;
  result->timings.decode = decode_ms;
  result->timings.total += decode_ms;
  return result;
}

}  // namespace segserve::client
