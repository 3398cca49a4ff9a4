// SPDX-License-Identifier: Apache-2.0
#include "client/calls/local.hpp"

#include <chrono>
#include <utility>

#include "core/base/exception_status.hpp"
#include "core/base/status_macros.hpp"
#include "proto/wire/prompts_message.hpp"
#include "proto/wire/result_message.hpp"
#include "proto/wire/track_message.hpp"
#include "segserve/segment.hpp"

namespace segserve::client {

namespace {

absl::StatusOr<wire::Result> segment_cloud(const CloudView& cloud, const std::string& view_rule,
                                           const codec::Placement& placement, const Options& options,
                                           const wire::Outputs& outputs, const std::optional<Prompts>& prompts,
                                           const std::optional<wire::TrackRequest>& tracking, const StopToken& stop) {
  if (prompts) RETURN_IF_ERROR(wire::check(*prompts));
  ASSIGN_OR_RETURN(Segmentation segmentation, segment(cloud, options, stop));
  std::optional<wire::Tracks> tracks;
  if (tracking) {
    ASSIGN_OR_RETURN(tracks, wire::follow(*tracking, cloud.view, stop, segmentation));
  }
  if (outputs.segments) RETURN_IF_ERROR(describe(cloud, options.threads, stop, segmentation));
  ASSIGN_OR_RETURN(auto selection,
                   wire::select_by_prompts(cloud, placement, segmentation, options, outputs, prompts, stop));
  const double total = segmentation.timings.total;
  wire::Result result = wire::make_result(std::move(segmentation), cloud, options, view_rule, SEGSERVE_VERSION);
  result.selection = std::move(selection);
  result.timings.total = total;
  result.tracks = std::move(tracks);
  result.in_this_process = true;
  return result;
}

absl::StatusOr<wire::Result> segment_payload(const Payload& payload, const Options& options,
                                             const wire::Outputs& outputs, const std::optional<Prompts>& prompts,
                                             const std::optional<wire::TrackRequest>& tracking, const StopToken& stop) {
  const auto start = std::chrono::steady_clock::now();
  ASSIGN_OR_RETURN(const codec::LabeledCloud scene, decode(payload, stop));
  const double decode_ms = std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - start).count();
  ASSIGN_OR_RETURN(wire::Result result,
                   segment_cloud(scene.cloud, scene.view_rule, scene.placement,
                                 codec::to_cloud(scene.placement, options), outputs, prompts, tracking, stop));
  wire::take_payload_facts(scene.placement, scene.warnings, result);
  result.timings.decode = decode_ms;
  result.timings.total += decode_ms;
  return result;
}

}  // namespace

absl::StatusOr<wire::Result> segment_here(const CloudView& cloud, const std::string& view_rule, const Options& options,
                                          const wire::Outputs& outputs, const StopToken& stop,
                                          const std::optional<Prompts>& prompts,
                                          const std::optional<wire::TrackRequest>& tracking) {
  try {
    return segment_cloud(cloud, view_rule, {}, options, outputs, prompts, tracking, stop);
  } catch (...) {
    return exception_status("segment the cloud in this process");
  }
}

absl::StatusOr<wire::Result> segment_here(const Payload& payload, const Options& options, const wire::Outputs& outputs,
                                          const StopToken& stop, const std::optional<Prompts>& prompts,
                                          const std::optional<wire::TrackRequest>& tracking) {
  try {
    return segment_payload(payload, options, outputs, prompts, tracking, stop);
  } catch (...) {
    return exception_status("segment the cloud in this process");
  }
}

}  // namespace segserve::client
