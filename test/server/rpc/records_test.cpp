// SPDX-License-Identifier: Apache-2.0
// Tests that every call of a real server has its record.
#include <future>

#include "gmock/gmock.h"
#include "test/server/support/fake_backend.hpp"
#include "test/server/support/record_keeper.hpp"
#include "test/server/support/running_server.hpp"
#include "test/server/support/server_scenes.hpp"

namespace segserve::server {
namespace {

using testing::SizeIs;

class Records : public testing::Test {
 protected:
  ServiceObservers observers() { return ServiceObservers({records_}); }

  const std::shared_ptr<RecordKeeper> records_ = std::make_shared<RecordKeeper>();
};

TEST_F(Records, OfAUnaryCallHaveAllNumbersBeforeTheClientHasItsAnswer) {
  RunningServer server(small_server(), core_backend_factory(), observers());
  v1::SegmentRequest request = request_for(wall_with_box());
  request.set_request_id("a wall");
  grpc::ClientContext context;
  context.AddMetadata("traceparent", "00-0af7651916cd43dd8448eb211c80319c-b7ad6b7169203331-01");
  v1::SegmentResponse response;
  ASSERT_TRUE(server.stub().Segment(&context, request, &response).ok());

  ASSERT_THAT(records_->frames(), SizeIs(1));
  const FrameRecord record = records_->frames()[0];
  EXPECT_EQ(record.call, FrameRecord::Call::kUnary);
  EXPECT_EQ(record.caller->peer.substr(0, 15), "ipv4:127.0.0.1:");
  EXPECT_EQ(record.traceparent, "00-0af7651916cd43dd8448eb211c80319c-b7ad6b7169203331-01");
  EXPECT_EQ(record.request_id, "a wall");
  EXPECT_EQ(record.payload_kind, v1::PAYLOAD_KIND_PLANAR);
  EXPECT_EQ(record.received_bytes, request.ByteSizeLong());
  EXPECT_EQ(record.sent_bytes, response.ByteSizeLong());
  EXPECT_EQ(record.outcome, v1::OUTCOME_KIND_RESULT);
  EXPECT_EQ(record.work.points, response.result().summary().points());
  EXPECT_EQ(record.work.voxels, response.result().summary().voxels());
  EXPECT_EQ(record.work.supervoxels, response.result().summary().supervoxels());
  EXPECT_EQ(record.work.segments, response.result().summary().segments());
  EXPECT_EQ(record.work.stages.normals, response.result().summary().timings().normals_ms());
  EXPECT_LE(record.arrival, record.queued);
  EXPECT_LE(record.queued, record.work.started);
  EXPECT_LE(record.work.encoded, record.delivered);
}

TEST_F(Records, OfWrongCallsSayWhatIsWrong) {
  RunningServer server(small_server(), core_backend_factory(), observers());
  EXPECT_FALSE(server.segment(request_for_pcd("no PCD file")).ok());
  EXPECT_FALSE(server.segment({}).ok());
  ASSERT_THAT(records_->frames(), SizeIs(2));
  EXPECT_EQ(records_->frames()[0].status.reason, wire::ErrorReason::kMalformedPayload);
  EXPECT_EQ(records_->frames()[1].status.reason, wire::ErrorReason::kInvalidField);
  EXPECT_EQ(records_->frames()[1].payload_kind, v1::PAYLOAD_KIND_UNSPECIFIED);
}

TEST_F(Records, OfCallsAndStreamsThatComeTooLateSayThatTheServerDrains) {
  Blockade blockade;
  RunningServer server(small_server(), blocking_factory(blockade), observers());
  grpc::ClientContext computed;
  auto first = server.segment_later(computed, request_for(equal_points(9, 0, 0, 1)));
  ASSERT_TRUE(eventually([&] { return blockade.entered() == 1; }));
  auto stopped = std::async(std::launch::async, [&server] { return server.server().stop(); });
  ASSERT_TRUE(eventually([&] {
    return !server.segment(v1::SegmentRequest()).ok() && !records_->frames().empty() &&
           records_->frames().back().status.reason == wire::ErrorReason::kDraining;
  }));
  grpc::ClientContext context;
  auto stream = server.stub().SegmentStream(&context);
  EXPECT_EQ(stream->Finish().error_code(), grpc::StatusCode::UNAVAILABLE);
  ASSERT_THAT(records_->streams(), SizeIs(1));
  EXPECT_FALSE(records_->streams()[0].is_opened);
  EXPECT_EQ(records_->streams()[0].status.reason, wire::ErrorReason::kDraining);
  blockade.release();
  EXPECT_TRUE(first.get().ok());
  EXPECT_TRUE(stopped.get());
}

TEST_F(Records, OfCallsThatMadeWayForOthersSaySo) {
  Blockade blockade;
  ServerOptions options = small_server();
  options.queue = 2;
  RunningServer server(options, blocking_factory(blockade), observers());
  const v1::SegmentRequest request = request_for(equal_points(9, 0, 0, 1));
  grpc::ClientContext computed, second, third;
  auto first_call = server.segment_later(computed, request);
  ASSERT_TRUE(eventually([&] { return blockade.entered() == 1; }));
  auto second_call = server.segment_later(second, request);
  auto third_call = server.segment_later(third, request);
  ASSERT_TRUE(eventually([&] { return server.server().calls() == 3; }));
  auto other = std::async(std::launch::async, [&] { return server.segment_from_elsewhere(request); });
  ASSERT_TRUE(eventually([&] { return !records_->frames().empty(); }));
  EXPECT_TRUE(records_->frames()[0].is_evicted);
  EXPECT_EQ(records_->frames()[0].status.reason, wire::ErrorReason::kQueueFull);
  blockade.release();
  EXPECT_TRUE(other.get().ok());
  EXPECT_TRUE(first_call.get().ok());
  EXPECT_NE(second_call.get().ok(), third_call.get().ok());
  EXPECT_THAT(records_->frames(), SizeIs(4));
}

TEST_F(Records, OfAStreamComeWithItsEnd) {
  RunningServer server(small_server(), core_backend_factory(), observers());
  grpc::ClientContext context;
  auto stream = server.stub().SegmentStream(&context);
  v1::SegmentStreamRequest message;
  message.mutable_open()->set_client_name("a robot");
  ASSERT_TRUE(stream->Write(message));
  ASSERT_TRUE(stream->WritesDone());
  v1::SegmentStreamResponse response;
  while (stream->Read(&response)) {
  }
  EXPECT_TRUE(stream->Finish().ok());
  ASSERT_THAT(records_->streams(), SizeIs(1));
  const StreamRecord record = records_->streams()[0];
  EXPECT_TRUE(record.is_opened);
  EXPECT_EQ(record.caller->client_name, "a robot");
  EXPECT_EQ(record.frames, 0U);
  EXPECT_EQ(record.status.code, absl::StatusCode::kOk);
}

}  // namespace
}  // namespace segserve::server
