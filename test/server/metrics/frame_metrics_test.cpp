// SPDX-License-Identifier: Apache-2.0
// Tests what the metrics make of the records of frames and streams.
#include "server/metrics/frame_metrics.hpp"

#include <chrono>
#include <memory>
#include <string>

#include "gmock/gmock.h"
#include "prometheus/text_serializer.h"
#include "server/metrics/refusal_cause.hpp"

namespace segserve::server {
namespace {

using namespace std::chrono_literals;
using testing::HasSubstr;
using testing::Not;
using wire::ErrorReason;

/// A frame of 100 points that took 10 ms in each of upload, queue, decoding, segmentation, encoding and delivery.
FrameRecord segmented_frame() {
  FrameRecord frame;
  frame.caller = std::make_shared<const Caller>();
  frame.payload_kind = v1::PAYLOAD_KIND_QUANTISED;
  frame.received_bytes = 200;
  frame.sent_bytes = 30;
  frame.arrival = FrameRecord::Time(1h);
  frame.uploaded = frame.queued = frame.arrival + 10ms;
  frame.work.started = frame.arrival + 20ms;
  frame.work.decoded = frame.arrival + 30ms;
  frame.work.segmented = frame.arrival + 40ms;
  frame.work.encoded = frame.decided = frame.arrival + 50ms;
  frame.delivered = frame.arrival + 60ms;
  frame.work.points = 100;
  frame.work.decoded_bytes = 1600;
  frame.work.voxels = 40;
  frame.work.segments = 4;
  frame.work.stages.voxels = 4;
  frame.work.stages.normals = 6;
  frame.outcome = v1::OUTCOME_KIND_RESULT;
  return frame;
}

class FrameMetricsTest : public testing::Test {
 protected:
  /// All metrics as Prometheus reads them.
  std::string text() const { return prometheus::TextSerializer().Serialize(registry_->Collect()); }
  /// The value of a metric, given with its labels.
  std::string value(const std::string& metric) const {
    const std::string all = "\n" + text(), name = "\n" + metric + " ";
    const std::size_t begin = all.find(name);
    if (begin == std::string::npos) return "absent";
    return all.substr(begin + name.size(), all.find('\n', begin + 1) - begin - name.size());
  }

  const std::shared_ptr<prometheus::Registry> registry_ = std::make_shared<prometheus::Registry>();
  FrameMetrics metrics_{registry_};
};

TEST_F(FrameMetricsTest, AllAreThereBeforeTheFirstFrame) {
  EXPECT_EQ(value("segserve_frames_total{call=\"stream\",outcome=\"dropped\"}"), "0");
  EXPECT_EQ(value("segserve_frames_total{call=\"unary\",outcome=\"failed\"}"), "0");
  EXPECT_EQ(value("segserve_frame_failures_total{code=\"ABORTED\",reason=\"CHECKSUM\"}"), "0");
  EXPECT_EQ(value("segserve_stream_ends_total{code=\"OK\",reason=\"UNSPECIFIED\"}"), "0");
  EXPECT_EQ(value("segserve_received_bytes_total{codec=\"pcd_file\"}"), "0");
  EXPECT_EQ(value("segserve_frame_stage_seconds_count{stage=\"supervoxels\"}"), "0");
  EXPECT_EQ(value("segserve_frame_queue_wait_seconds_count"), "0");
  for (const char* cause : refusal_causes()) {
    EXPECT_EQ(value(std::string("segserve_refusals_total{cause=\"") + cause + "\"}"), "0");
  }
}

TEST_F(FrameMetricsTest, AFrameWithAResultIsInEveryMetricOnce) {
  metrics_.on_frame(segmented_frame());
  EXPECT_EQ(value("segserve_frames_total{call=\"stream\",outcome=\"result\"}"), "1");
  EXPECT_EQ(value("segserve_received_bytes_total{codec=\"quantised\"}"), "200");
  EXPECT_EQ(value("segserve_decoded_bytes_total{codec=\"quantised\"}"), "1600");
  EXPECT_EQ(value("segserve_sent_bytes_total{codec=\"quantised\"}"), "30");
  EXPECT_EQ(value("segserve_voxels_total"), "40");
  EXPECT_EQ(value("segserve_segments_total"), "4");
  EXPECT_EQ(value("segserve_frame_points_sum"), "100");
  EXPECT_EQ(value("segserve_frame_duration_seconds_count{call=\"stream\"}"), "1");
  EXPECT_EQ(value("segserve_frame_duration_seconds_sum{call=\"stream\"}"), "0.05");
  EXPECT_EQ(value("segserve_frame_upload_seconds_sum"), "0.01");
  EXPECT_EQ(value("segserve_frame_queue_wait_seconds_sum"), "0.01");
  EXPECT_EQ(value("segserve_frame_delivery_seconds_sum"), "0.01");
  EXPECT_EQ(value("segserve_frame_stage_seconds_sum{stage=\"decode\"}"), "0.01");
  EXPECT_EQ(value("segserve_frame_stage_seconds_sum{stage=\"voxels\"}"), "0.004");
  EXPECT_EQ(value("segserve_frame_stage_seconds_sum{stage=\"normals\"}"), "0.006");
  EXPECT_EQ(value("segserve_frame_stage_seconds_sum{stage=\"encode\"}"), "0.01");
  EXPECT_EQ(value("segserve_frame_stage_seconds_count{stage=\"labels\"}"), "1");
}

TEST_F(FrameMetricsTest, AFrameThatCameNoFurtherThanTheQueueHasNoTimesOfLaterStages) {
  FrameRecord frame = segmented_frame();
  frame.work = {};
  frame.delivered.reset();
  frame.outcome = v1::OUTCOME_KIND_CANCELLED;
  metrics_.on_frame(frame);
  EXPECT_EQ(value("segserve_frames_total{call=\"stream\",outcome=\"cancelled\"}"), "1");
  EXPECT_EQ(value("segserve_received_bytes_total{codec=\"quantised\"}"), "200");
  EXPECT_EQ(value("segserve_frame_upload_seconds_count"), "1");
  for (const char* name : {"segserve_frame_queue_wait_seconds_count", "segserve_frame_delivery_seconds_count",
                           "segserve_frame_points_count", "segserve_frame_stage_seconds_count{stage=\"decode\"}",
                           "segserve_frame_duration_seconds_count{call=\"stream\"}"}) {
    EXPECT_EQ(value(name), "0") << name;
  }
}

TEST_F(FrameMetricsTest, AFailedFrameIsCountedByItsError) {
  FrameRecord frame = segmented_frame();
  frame.call = FrameRecord::Call::kUnary;
  frame.outcome = v1::OUTCOME_KIND_FAILED;
  frame.status = {
      .code = absl::StatusCode::kResourceExhausted, .reason = ErrorReason::kQueueFull, .limit = "max_queue"};
  metrics_.on_frame(frame);
  EXPECT_EQ(value("segserve_frames_total{call=\"unary\",outcome=\"failed\"}"), "1");
  EXPECT_EQ(value("segserve_frame_failures_total{code=\"RESOURCE_EXHAUSTED\",reason=\"QUEUE_FULL\"}"), "1");
  EXPECT_EQ(value("segserve_refusals_total{cause=\"queue_frames\"}"), "1");
  EXPECT_EQ(value("segserve_frame_upload_seconds_count"), "0") << "a unary call has no upload of its own";
}

TEST_F(FrameMetricsTest, EachRefusalHasItsCause) {
  const StatusFacts full{.code = absl::StatusCode::kResourceExhausted, .reason = ErrorReason::kQueueFull};
  const auto with_limit = [&full](const char* limit) {
    StatusFacts facts = full;
    facts.limit = limit;
    return facts;
  };
  EXPECT_STREQ(refusal_cause(with_limit("max_queue_bytes"), false), "queue_bytes");
  EXPECT_STREQ(refusal_cause(with_limit("max_queue_points"), false), "queue_points");
  EXPECT_STREQ(refusal_cause(with_limit("memory_bytes"), false), "memory");
  EXPECT_STREQ(refusal_cause(full, true), "eviction");
  EXPECT_STREQ(refusal_cause({.code = absl::StatusCode::kUnavailable, .reason = ErrorReason::kDraining}, false),
               "draining");
  EXPECT_STREQ(refusal_cause({.code = absl::StatusCode::kUnauthenticated, .reason = ErrorReason::kTokenExpired}, false),
               "token");
  EXPECT_STREQ(
      refusal_cause({.code = absl::StatusCode::kResourceExhausted, .reason = ErrorReason::kQuotaExceeded}, false),
      "quota");
  EXPECT_EQ(refusal_cause({.code = absl::StatusCode::kInvalidArgument, .reason = ErrorReason::kInvalidField}, false),
            nullptr);
  EXPECT_EQ(refusal_cause({}, false), nullptr);
}

TEST_F(FrameMetricsTest, AStreamIsCountedByItsEndAndRefusedOnlyIfItNeverOpened) {
  const StatusFacts draining{.code = absl::StatusCode::kUnavailable, .reason = ErrorReason::kDraining};
  metrics_.on_stream({.is_opened = true, .status = draining});
  EXPECT_EQ(value("segserve_stream_ends_total{code=\"UNAVAILABLE\",reason=\"DRAINING\"}"), "1");
  EXPECT_EQ(value("segserve_refusals_total{cause=\"draining\"}"), "0");
  metrics_.on_stream({.is_opened = false, .status = draining});
  EXPECT_EQ(value("segserve_stream_ends_total{code=\"UNAVAILABLE\",reason=\"DRAINING\"}"), "2");
  EXPECT_EQ(value("segserve_refusals_total{cause=\"draining\"}"), "1");
}

TEST_F(FrameMetricsTest, NothingThatAClientChoosesIsInThem) {
  FrameRecord frame = segmented_frame();
  frame.caller = std::make_shared<const Caller>(Caller{
      .peer = "ipv4:192.0.2.7:1", .subject = "my-subject", .client_name = "my-client", .traceparent = "my-trace"});
  frame.request_id = "my-request";
  frame.payload_kind = static_cast<v1::PayloadKind>(77);
  metrics_.on_frame(frame);
  EXPECT_EQ(value("segserve_received_bytes_total{codec=\"unknown\"}"), "200");
  for (const char* chosen : {"192.0.2.7", "my-"}) {
    EXPECT_THAT(text(), Not(HasSubstr(chosen)));
  }
}

}  // namespace
}  // namespace segserve::server
