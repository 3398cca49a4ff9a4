// SPDX-License-Identifier: Apache-2.0
#include "server/metrics/frame_metrics.hpp"

#include <chrono>
#include <cstddef>
#include <optional>
#include <string>
#include <string_view>
#include <utility>

#include "absl/status/status.h"
#include "proto/wire/codec_message.hpp"
#include "server/metrics/refusal_cause.hpp"

namespace segserve::server {
namespace {

using prometheus::Counter;
using prometheus::Family;
using prometheus::Histogram;
using prometheus::Registry;
using wire::ErrorReason;

// The order is that of v1::OutcomeKind. The first is never used.
constexpr std::array<const char*, v1::OutcomeKind_ARRAYSIZE> kOutcomeNames{"",        "result",    "dropped",
                                                                           "expired", "cancelled", "failed"};
constexpr std::array<const char*, 2> kCallNames{"unary", "stream"};
constexpr std::array<const char*, 9> kStageNames{"decode",  "voxels", "normals",  "supervoxels", "graph",
                                                 "merging", "labels", "segments", "encode"};

/// Upper ends of buckets, seconds: from a fast stage to the longest that a frame may take by default.
const Histogram::BucketBoundaries kSeconds{0.0001, 0.0002, 0.0005, 0.001, 0.002, 0.005, 0.01, 0.02, 0.05,
                                           0.1,    0.2,    0.5,    1,     2,     5,     10,   20,   60};
const Histogram::BucketBoundaries kPoints{1e3, 1e4, 3e4, 1e5, 2e5, 3e5, 5e5, 1e6, 2e6, 5e6, 1e7};

/// The errors that are expected. Others that come are added when they do; they are bounded by the API's codes and
/// reasons.
constexpr std::array<std::pair<absl::StatusCode, ErrorReason>, 15> kErrors{{
    {absl::StatusCode::kInvalidArgument, ErrorReason::kInvalidField},
    {absl::StatusCode::kInvalidArgument, ErrorReason::kMalformedPayload},
    {absl::StatusCode::kInvalidArgument, ErrorReason::kInvalidCloud},
    {absl::StatusCode::kInvalidArgument, ErrorReason::kLimitExceeded},
    {absl::StatusCode::kInvalidArgument, ErrorReason::kProtocolViolation},
    {absl::StatusCode::kResourceExhausted, ErrorReason::kLimitExceeded},
    {absl::StatusCode::kResourceExhausted, ErrorReason::kQueueFull},
    {absl::StatusCode::kResourceExhausted, ErrorReason::kQuotaExceeded},
    {absl::StatusCode::kUnauthenticated, ErrorReason::kTokenMissing},
    {absl::StatusCode::kUnauthenticated, ErrorReason::kTokenInvalid},
    {absl::StatusCode::kUnauthenticated, ErrorReason::kTokenExpired},
    {absl::StatusCode::kUnavailable, ErrorReason::kDraining},
    {absl::StatusCode::kDeadlineExceeded, ErrorReason::kUploadStalled},
    {absl::StatusCode::kAborted, ErrorReason::kChecksum},
    {absl::StatusCode::kInternal, ErrorReason::kInternal},
}};

Family<Counter>& counters(Registry& registry, const char* name, const char* help) {
  return prometheus::BuildCounter().Name(name).Help(help).Register(registry);
}

Family<Histogram>& histograms(Registry& registry, const char* name, const char* help) {
  return prometheus::BuildHistogram().Name(name).Help(help).Register(registry);
}

prometheus::Labels labels_of(absl::StatusCode code, ErrorReason reason) {
  return {{"code", absl::StatusCodeToString(code)}, {"reason", std::string(wire::name(reason))}};
}

double seconds(std::chrono::steady_clock::duration duration) { return std::chrono::duration<double>(duration).count(); }

/// Measures the time between two points if the frame came to both.
void observe(Histogram& histogram, const std::optional<FrameRecord::Time>& begin,
             const std::optional<FrameRecord::Time>& end) {
  if (begin && end) histogram.Observe(seconds(*end - *begin));
}

}  // namespace

FrameMetrics::FrameMetrics(std::shared_ptr<Registry> registry)
    : registry_(std::move(registry)),
      upload_(histograms(*registry_, "segserve_frame_upload_seconds",
                         "Time from the header of a frame of a stream to its last chunk.")
                  .Add({}, kSeconds)),
      queue_wait_(histograms(*registry_, "segserve_frame_queue_wait_seconds",
                             "Time that a frame with its payload waited for a worker.")
                      .Add({}, kSeconds)),
      delivery_(histograms(*registry_, "segserve_frame_delivery_seconds",
                           "Time from the outcome of a frame until gRPC had taken all of it.")
                    .Add({}, kSeconds)),
      points_(histograms(*registry_, "segserve_frame_points", "Points of each decoded cloud, finite or not.")
                  .Add({}, kPoints)),
      voxels_(counters(*registry_, "segserve_voxels_total", "Voxels of all segmented clouds.").Add({})),
      segments_(counters(*registry_, "segserve_segments_total", "Segments of all segmented clouds.").Add({})),
      failures_(counters(*registry_, "segserve_frame_failures_total",
                         "Frames with the outcome failed, by the code and the reason of their error.")),
      refusals_(counters(*registry_, "segserve_refusals_total",
                         "Frames, streams and questions about the server that were turned away for lack of room or of "
                         "rights, by cause.")),
      stream_ends_(counters(*registry_, "segserve_stream_ends_total",
                            "Streams that ended, also those that were refused, by code and reason.")) {
  register_calls();
  register_stages();
  register_codecs();
  register_errors();
}

void FrameMetrics::register_calls() {
  auto& frames =
      counters(*registry_, "segserve_frames_total", "Frames that ended, by the kind of call and by outcome.");
  auto& durations = histograms(*registry_, "segserve_frame_duration_seconds",
                               "Time from the arrival of a frame to its outcome, for frames with a result.");
  for (std::size_t call = 0; call < calls_.size(); ++call) {
    for (std::size_t outcome = 1; outcome < kOutcomes; ++outcome) {
      calls_[call].outcomes[outcome] = &frames.Add({{"call", kCallNames[call]}, {"outcome", kOutcomeNames[outcome]}});
    }
    calls_[call].duration = &durations.Add({{"call", kCallNames[call]}}, kSeconds);
  }
}

void FrameMetrics::register_stages() {
  auto& stages = histograms(*registry_, "segserve_frame_stage_seconds", "Time of each stage of a frame on a worker.");
  for (std::size_t stage = 0; stage < kStages; ++stage) {
    stages_[stage] = &stages.Add({{"stage", kStageNames[stage]}}, kSeconds);
  }
}

void FrameMetrics::register_codecs() {
  auto& received =
      counters(*registry_, "segserve_received_bytes_total", "Bytes of requests and of frames of streams, by codec.");
  auto& decoded = counters(*registry_, "segserve_decoded_bytes_total", "Bytes of decoded clouds, by codec.");
  auto& sent = counters(*registry_, "segserve_sent_bytes_total", "Bytes of answers, by the codec of the payload.");
  for (std::size_t codec = 0; codec < kCodecs; ++codec) {
    const prometheus::Labels labels{{"codec", std::string(wire::name(static_cast<v1::PayloadKind>(codec)))}};
    codecs_[codec] = {&received.Add(labels), &decoded.Add(labels), &sent.Add(labels)};
  }
}

void FrameMetrics::register_errors() {
  for (const auto& [code, reason] : kErrors) {
    failures_.Add(labels_of(code, reason));
    stream_ends_.Add(labels_of(code, reason));
  }
  stream_ends_.Add(labels_of(absl::StatusCode::kOk, ErrorReason::kUnspecified));
  stream_ends_.Add(labels_of(absl::StatusCode::kCancelled, ErrorReason::kCancelled));
  for (const char* cause : refusal_causes()) refusals_.Add({{"cause", cause}});
}

void FrameMetrics::on_frame(const FrameRecord& frame) {
  const CallMetrics& call = calls_[static_cast<std::size_t>(frame.call)];
  call.outcomes[static_cast<std::size_t>(frame.outcome)]->Increment();
  if (frame.outcome == v1::OUTCOME_KIND_RESULT) call.duration->Observe(seconds(frame.decided - frame.arrival));
  if (frame.outcome == v1::OUTCOME_KIND_FAILED)
    failures_.Add(labels_of(frame.status.code, frame.status.reason)).Increment();
  count_refusal(frame.status, frame.is_evicted);
  if (frame.call == FrameRecord::Call::kStream) observe(upload_, frame.arrival, frame.uploaded);
  observe(queue_wait_, frame.queued, frame.work.started);
  observe(delivery_, frame.decided, frame.delivered);
  measure_work(frame.work);
  count_bytes(frame);
}

void FrameMetrics::measure_work(const FrameWork& work) {
  observe(*stages_.front(), work.started, work.decoded);
  if (work.decoded) points_.Observe(static_cast<double>(work.points));
  observe(*stages_.back(), work.segmented, work.encoded);
  if (!work.segmented) return;
  const StageTimings& stages = work.stages;
  const std::array milliseconds{stages.voxels,  stages.normals, stages.supervoxels, stages.graph,
                                stages.merging, stages.labels,  stages.segments};
  constexpr double kSecond = 1000;
  for (std::size_t i = 0; i < milliseconds.size(); ++i) stages_[i + 1]->Observe(milliseconds[i] / kSecond);
  voxels_.Increment(static_cast<double>(work.voxels));
  segments_.Increment(work.segments);
}

void FrameMetrics::count_bytes(const FrameRecord& frame) {
  const auto kind = static_cast<std::size_t>(frame.payload_kind);
  const CodecMetrics& codec = codecs_[kind < kCodecs ? kind : 0];
  codec.received_bytes->Increment(static_cast<double>(frame.received_bytes));
  codec.decoded_bytes->Increment(static_cast<double>(frame.work.decoded_bytes));
  codec.sent_bytes->Increment(static_cast<double>(frame.sent_bytes));
}

void FrameMetrics::count_refusal(const StatusFacts& status, bool is_evicted) {
  if (const char* cause = refusal_cause(status, is_evicted)) refusals_.Add({{"cause", cause}}).Increment();
}

void FrameMetrics::on_stream(const StreamRecord& stream) {
  stream_ends_.Add(labels_of(stream.status.code, stream.status.reason)).Increment();
  if (!stream.is_opened) count_refusal(stream.status, false);
}

void FrameMetrics::on_refused_question(const RefusedQuestion& question) { count_refusal(question.status, false); }

}  // namespace segserve::server
