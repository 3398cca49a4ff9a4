// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>
#include <memory>

#include "prometheus/counter.h"
#include "prometheus/family.h"
#include "prometheus/histogram.h"
#include "prometheus/registry.h"
#include "server/observe/service_observer.hpp"

namespace segserve::server {

/// Counts and measures the frames and streams that are over. Everything is registered from the beginning with 0, so
/// that rates are right from the first frame on, and no label has a value that a client chooses. docs/operations.md
/// lists the metrics. A frame costs about a microsecond, most of it the short locks of prometheus-cpp's histograms.
class FrameMetrics final : public ServiceObserver {
 public:
  explicit FrameMetrics(std::shared_ptr<prometheus::Registry> registry);

  void on_frame(const FrameRecord& frame) override;
  void on_stream(const StreamRecord& stream) override;
  void on_refused_question(const RefusedQuestion& question) override;

 private:
  /// Stages on a worker, in their order.
  static constexpr std::size_t kStages = 9;
  /// Kinds of payload; the first is for frames that have none, or one that this version does not know.
  static constexpr std::size_t kCodecs = v1::PayloadKind_ARRAYSIZE;
  static constexpr std::size_t kOutcomes = v1::OutcomeKind_ARRAYSIZE;

  /// Frames of one kind of call.
  struct CallMetrics {
    std::array<prometheus::Counter*, kOutcomes> outcomes{};  // by v1::OutcomeKind
    prometheus::Histogram* duration = nullptr;
  };
  /// Payloads of one kind.
  struct CodecMetrics {
    prometheus::Counter* received_bytes = nullptr;
    prometheus::Counter* decoded_bytes = nullptr;
    prometheus::Counter* sent_bytes = nullptr;
  };

  void register_calls();
  void register_stages();
  void register_codecs();
  void register_errors();
  void count_bytes(const FrameRecord& frame);
  void measure_work(const FrameWork& work);
  /// Counts a frame, stream or question that was turned away although nothing was wrong with it.
  void count_refusal(const StatusFacts& status, bool is_evicted);

  const std::shared_ptr<prometheus::Registry> registry_;
  std::array<CallMetrics, 2> calls_;  // by FrameRecord::Call
  std::array<CodecMetrics, kCodecs> codecs_;
  std::array<prometheus::Histogram*, kStages> stages_{};
  prometheus::Histogram &upload_, &queue_wait_, &delivery_, &points_;
  prometheus::Counter &voxels_, &segments_;
  prometheus::Family<prometheus::Counter>&failures_, &refusals_, &stream_ends_;
};

}  // namespace segserve::server
