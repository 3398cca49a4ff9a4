// SPDX-License-Identifier: Apache-2.0
#include "server/app/frame_reporter.hpp"

#include <utility>

#include "core/base/status_macros.hpp"
#include "server/observe/frame_trace.hpp"
#include "server/traces/otlp_settings.hpp"

namespace segserve::server {

FrameReporter::FrameReporter(std::unique_ptr<SpanExporter> exporter, double sampled_share)
    : exporter_(std::move(exporter)), sampled_share_(exporter_ ? std::optional(sampled_share) : std::nullopt) {}

void FrameReporter::on_frame(const FrameRecord& frame) {
  const FrameTrace trace = trace_of(frame.traceparent, sampled_share_);
  log_.write(frame, trace);
  if (exporter_ && !trace.span_id.empty()) {
    exporter_->add(traced_now(frame, trace));
  }
}

void FrameReporter::on_stream(const StreamRecord& stream) {
  log_.write(stream, trace_of(stream.caller->traceparent, std::nullopt));
}

void FrameReporter::on_refused_question(const RefusedQuestion& question) { log_.write(question); }

absl::StatusOr<std::shared_ptr<ServiceObserver>> make_reporter(const Flags& flags) {
  std::unique_ptr<SpanExporter> exporter;
  if (!flags.otlp_endpoint.empty()) {
    ASSIGN_OR_RETURN(OtlpSettings settings, otlp_settings(flags.otlp_endpoint));
    exporter = std::make_unique<SpanExporter>(std::move(settings));
  }
  return std::make_shared<FrameReporter>(std::move(exporter), flags.otlp_sample_ratio);
}

}  // namespace segserve::server
