// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <optional>

#include "absl/status/statusor.h"
#include "server/app/flags.hpp"
#include "server/log/frame_log.hpp"
#include "server/observe/service_observer.hpp"
#include "server/traces/span_exporter.hpp"

namespace segserve::server {

/// Writes what becomes of frames and streams to the log, and hands frames that are recorded to an exporter of traces.
class FrameReporter final : public ServiceObserver {
 public:
  /// Without an exporter there are no traces. `sampled_share` as in trace_of.
  FrameReporter(std::unique_ptr<SpanExporter> exporter, double sampled_share);

  void on_frame(const FrameRecord& frame) override;
  void on_stream(const StreamRecord& stream) override;
  void on_refused_question(const RefusedQuestion& question) override;

 private:
  const std::unique_ptr<SpanExporter> exporter_;
  const std::optional<double> sampled_share_;  // unset: there are no traces
  FrameLog log_;
};

/// The reporter that the flags ask for. INVALID_ARGUMENT if the settings of traces are wrong.
absl::StatusOr<std::shared_ptr<ServiceObserver>> make_reporter(const Flags& flags);

}  // namespace segserve::server
