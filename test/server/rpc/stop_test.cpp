// SPDX-License-Identifier: Apache-2.0
#include "gmock/gmock.h"
#include "test/server/support/fake_backend.hpp"
#include "test/server/support/running_server.hpp"
#include "test/server/support/server_scenes.hpp"

// A client that gives up stops the computation, which frees the worker for others.
namespace segserve::server {
namespace {

using namespace std::chrono_literals;

class Stop : public testing::Test {
 protected:
  Blockade blockade_;
  RunningServer server_{small_server(), blocking_factory(blockade_)};
  const v1::SegmentRequest request_ = request_for(equal_points(9, 0, 0, 1));
};

TEST_F(Stop, CancellationEndsTheComputation) {
  grpc::ClientContext context;
  auto call = server_.segment_later(context, request_);
  ASSERT_TRUE(eventually([&] { return blockade_.entered() == 1; }));
  context.TryCancel();
  EXPECT_EQ(call.get().code(), absl::StatusCode::kCancelled);
  EXPECT_TRUE(eventually([&] { return blockade_.stopped() == 1 && server_.server().calls() == 0; }));
}

TEST_F(Stop, DeadlineEndsTheComputation) {
  grpc::ClientContext context;
  context.set_deadline(std::chrono::system_clock::now() + 200ms);
  auto call = server_.segment_later(context, request_);
  EXPECT_EQ(call.get().code(), absl::StatusCode::kDeadlineExceeded);
  EXPECT_TRUE(eventually([&] { return server_.server().calls() == 0; }));
  EXPECT_EQ(blockade_.stopped(), blockade_.entered());
}

TEST_F(Stop, ACallThatWaitsIsTakenOutOfTheQueue) {
  grpc::ClientContext computed, waiting;
  auto first = server_.segment_later(computed, request_);
  ASSERT_TRUE(eventually([&] { return blockade_.entered() == 1; }));
  auto second = server_.segment_later(waiting, request_);
  ASSERT_TRUE(eventually([&] { return server_.server().calls() == 2; }));
  waiting.TryCancel();
  EXPECT_EQ(second.get().code(), absl::StatusCode::kCancelled);
  EXPECT_TRUE(eventually([&] { return server_.server().calls() == 1; })) << "while the first is still computed";
  blockade_.release();
  EXPECT_TRUE(first.get().ok());
  EXPECT_EQ(blockade_.entered(), 1);
}

TEST_F(Stop, TheWorkerServesOthersAfterwards) {
  grpc::ClientContext context;
  auto call = server_.segment_later(context, request_);
  ASSERT_TRUE(eventually([&] { return blockade_.entered() == 1; }));
  context.TryCancel();
  call.wait();
  blockade_.release();
  EXPECT_TRUE(server_.segment(request_).ok());
}

TEST(StopCore, CancellationReachesThePipeline) {
  RunningServer server;
  v1::SegmentRequest request = request_for(wall_with_box(900, 600));
  grpc::ClientContext context;
  auto call = server.segment_later(context, request);
  ASSERT_TRUE(eventually([&] { return server.server().calls() == 1; }));
  context.TryCancel();
  EXPECT_EQ(call.get().code(), absl::StatusCode::kCancelled);
  EXPECT_TRUE(eventually([&] { return server.server().calls() == 0; }));
}

}  // namespace
}  // namespace segserve::server
