// SPDX-License-Identifier: Apache-2.0
#include <future>

#include "gmock/gmock.h"
#include "proto/wire/status_message.hpp"
#include "test/server/support/fake_backend.hpp"
#include "test/server/support/running_server.hpp"
#include "test/server/support/server_scenes.hpp"

namespace segserve::server {
namespace {

using namespace std::chrono_literals;
using Clock = std::chrono::steady_clock;
using grpc::health::v1::HealthCheckResponse;

class Drain : public testing::Test {
 protected:
  std::future<bool> stop_later(RunningServer& server) {
    return std::async(std::launch::async, [&server] { return server.server().stop(); });
  }

  Blockade blockade_;
  const v1::SegmentRequest request_ = request_for(equal_points(9, 0, 0, 1));
};

TEST_F(Drain, CallsInFlightFinishNewOnesAreRefusedAndHealthSaysSo) {
  RunningServer server(small_server(), blocking_factory(blockade_));
  EXPECT_EQ(server.health(), HealthCheckResponse::SERVING);
  EXPECT_EQ(server.health("segserve.v1.SegmentationService"), HealthCheckResponse::SERVING);
  grpc::ClientContext computed, waiting;
  auto first = server.segment_later(computed, request_);
  ASSERT_TRUE(eventually([&] { return blockade_.entered() == 1; }));
  auto second = server.segment_later(waiting, request_);
  ASSERT_TRUE(eventually([&] { return server.server().calls() == 2; }));

  auto stopped = stop_later(server);
  ASSERT_TRUE(eventually([&] { return server.health() == HealthCheckResponse::NOT_SERVING; }));
  EXPECT_EQ(server.health("segserve.v1.SegmentationService"), HealthCheckResponse::NOT_SERVING);
  absl::Status refused;
  ASSERT_TRUE(eventually([&] {
    grpc::ClientContext context;
    context.set_deadline(std::chrono::system_clock::now() +
                         50ms);  // calls are refused a moment after health has changed
    v1::SegmentResponse response;
    refused = wire::from_grpc(server.stub().Segment(&context, request_, &response));
    return refused.code() == absl::StatusCode::kUnavailable;
  }));
  EXPECT_EQ(wire::details_of(refused).reason, wire::ErrorReason::kDraining);
  EXPECT_TRUE(wire::details_of(refused).retry_delay.has_value());
  EXPECT_EQ(stopped.wait_for(0ms), std::future_status::timeout);

  blockade_.release();
  EXPECT_TRUE(first.get().ok());
  EXPECT_TRUE(second.get().ok());
  EXPECT_TRUE(stopped.get()) << "nothing was cancelled";
  EXPECT_FALSE(server.segment(request_).ok()) << "nobody listens any more";
}

TEST_F(Drain, TheGracePeriodEndsWhatDoesNot) {
  ServerOptions options = small_server();
  options.grace_period = 100ms;
  RunningServer server(options, blocking_factory(blockade_));
  grpc::ClientContext computed, waiting;
  auto first = server.segment_later(computed, request_);
  ASSERT_TRUE(eventually([&] { return blockade_.entered() == 1; }));
  auto second = server.segment_later(waiting, request_);
  ASSERT_TRUE(eventually([&] { return server.server().calls() == 2; }));
  const Clock::time_point begin = Clock::now();
  EXPECT_FALSE(server.server().stop());
  EXPECT_LT(Clock::now() - begin, 10s);
  EXPECT_FALSE(first.get().ok());
  EXPECT_FALSE(second.get().ok());
  EXPECT_EQ(blockade_.stopped(), blockade_.entered()) << "a call that waited may reach a worker before it is withdrawn";
}

TEST_F(Drain, AnOpenHealthWatchDoesNotHoldIt) {
  RunningServer server;
  grpc::ClientContext context;
  const auto stub = grpc::health::v1::Health::NewStub(server.channel());
  const auto watch = stub->Watch(&context, {});
  HealthCheckResponse seen;
  ASSERT_TRUE(watch->Read(&seen));
  EXPECT_EQ(seen.status(), HealthCheckResponse::SERVING);
  auto stopped = stop_later(server);
  ASSERT_TRUE(watch->Read(&seen));
  EXPECT_EQ(seen.status(), HealthCheckResponse::NOT_SERVING);
  EXPECT_EQ(stopped.wait_for(10s), std::future_status::ready) << "of a grace period of 20 s";
}

TEST_F(Drain, AnIdleServerStillTellsLateCallsToGoElsewhere) {
  ServerOptions options = small_server();
  options.drain_delay = 1s;
  RunningServer server(options);
  ASSERT_TRUE(server.segment(request_).ok());
  auto stopped = stop_later(server);
  absl::Status refused;
  ASSERT_TRUE(eventually([&] { return !(refused = server.segment(request_).status()).ok(); }));
  EXPECT_EQ(refused.code(), absl::StatusCode::kUnavailable) << refused;
  EXPECT_EQ(wire::details_of(refused).reason, wire::ErrorReason::kDraining);
  EXPECT_TRUE(stopped.get());
}

TEST_F(Drain, StoppingTwiceIsFine) {
  RunningServer server;
  EXPECT_TRUE(server.server().stop());
  EXPECT_TRUE(server.server().stop());
}

TEST_F(Drain, ThePortIsFreeAfterwardsAndNotBefore) {
  RunningServer first;
  ServerOptions options = small_server();
  options.listen = first.server().address();
  const auto refused = Server::start(options);
  EXPECT_EQ(refused.status().code(), absl::StatusCode::kUnavailable);
  EXPECT_THAT(std::string(refused.status().message()),
              testing::AllOf(testing::HasSubstr(options.listen), testing::HasSubstr("in use")));
  first.server().stop();
  EXPECT_TRUE(Server::start(options).ok());
}

}  // namespace
}  // namespace segserve::server
