// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <future>
#include <string>
#include <vector>

#include "gmock/gmock.h"
#include "segserve/codec/pcd.hpp"
#include "test/server/support/fake_backend.hpp"
#include "test/server/support/running_server.hpp"
#include "test/server/support/server_scenes.hpp"

namespace segserve::server {
namespace {

using testing::Contains;
using testing::Pair;

wire::ErrorDetails over_limit(RunningServer& server, const v1::SegmentRequest& request) {
  const absl::Status status = server.segment(request).status();
  EXPECT_EQ(status.code(), absl::StatusCode::kInvalidArgument) << status;
  const wire::ErrorDetails details = wire::details_of(status);
  EXPECT_EQ(details.reason, wire::ErrorReason::kLimitExceeded) << status;
  return details;
}

TEST(Limits, TooManyPointsInEveryPayload) {
  ServerOptions options = small_server();
  options.max_points = 99;
  RunningServer server(options);
  const Cloud cloud = equal_points(100, 0, 0, 1);
  for (const auto& request : {request_for(cloud), request_for(cloud, v1::COMPRESSION_ZSTD),
                              request_for_pcd(codec::encode_pcd(cloud, {}, codec::PcdEncoding::kBinaryCompressed))}) {
    const wire::ErrorDetails details = over_limit(server, request);
    EXPECT_THAT(details.metadata, testing::UnorderedElementsAre(Pair("limit", "max_points"), Pair("allowed", "99"),
                                                                Pair("actual", "100")));
  }
  EXPECT_TRUE(server.segment(request_for(equal_points(99, 0, 0, 1))).ok());
}

TEST(Limits, TooManyDecodedBytes) {
  ServerOptions options = small_server();
  options.max_decoded_bytes = 100 * 15;
  RunningServer server(options);
  EXPECT_TRUE(server.segment(request_for(equal_points(100, 0, 0, 1), v1::COMPRESSION_ZSTD)).ok());
  const auto details = over_limit(server, request_for(equal_points(101, 0, 0, 1), v1::COMPRESSION_ZSTD));
  EXPECT_THAT(details.metadata, Contains(Pair("limit", "max_decoded_bytes")));
}

TEST(Limits, ARequestALittleTooLargeGetsOurError) {
  RunningServer server;
  const auto details = over_limit(server, request_for_pcd(std::string(wire::kMaxRequestBytes, 'x')));
  EXPECT_THAT(details.metadata, Contains(Pair("limit", "max_message_bytes")));
  EXPECT_THAT(details.metadata, Contains(Pair("allowed", "8388608")));
}

TEST(Limits, ARequestFarTooLargeIsRefusedUnread) {
  RunningServer server;
  const auto details = over_limit(server, request_for_pcd(std::string(20 << 20, 'x')));
  EXPECT_THAT(details.metadata, Contains(Pair("limit", "max_message_bytes")));
  EXPECT_TRUE(server.segment(request_for(equal_points(9, 0, 0, 1))).ok()) << "on the same connection";
}

TEST(Limits, ThreadsAreLoweredToTheServersLimit) {
  ServerOptions options = small_server();
  options.threads = 2;
  std::atomic<std::uint32_t> used = 0;
  RunningServer server(options, fake_factory([&used](const CloudView& cloud, const Options& asked, const StopToken&) {
                         used = asked.threads;
                         Segmentation result;
                         result.labels.assign(cloud.size(), 0);
                         return absl::StatusOr<Segmentation>(result);
                       }));
  v1::SegmentRequest request = request_for(equal_points(9, 0, 0, 1));
  request.mutable_options()->set_threads(16);
  EXPECT_TRUE(server.segment(request).ok());
  EXPECT_EQ(used, 2U);
}

TEST(Limits, AFullQueueSaysWhenToTryAgain) {
  Blockade blockade;
  ServerOptions options = small_server();
  options.queue = 1;
  RunningServer server(options, blocking_factory(blockade));
  const v1::SegmentRequest request = request_for(equal_points(9, 0, 0, 1));
  grpc::ClientContext first_context, second_context;
  auto first = server.segment_later(first_context, request);
  ASSERT_TRUE(eventually([&] { return blockade.entered() == 1; }));
  auto second = server.segment_later(second_context, request);
  ASSERT_TRUE(eventually([&] { return server.server().calls() == 2; }));

  const absl::Status refused = server.segment(request).status();
  EXPECT_EQ(refused.code(), absl::StatusCode::kResourceExhausted) << refused;
  const wire::ErrorDetails details = wire::details_of(refused);
  EXPECT_EQ(details.reason, wire::ErrorReason::kQueueFull);
  EXPECT_THAT(details.metadata,
              testing::UnorderedElementsAre(Pair("limit", "max_queue"), Pair("allowed", "2"), Pair("actual", "3")));
  ASSERT_TRUE(details.retry_delay.has_value());
  EXPECT_GT(details.retry_delay->count(), 0);

  blockade.release();
  EXPECT_TRUE(first.get().ok());
  EXPECT_TRUE(second.get().ok());
  EXPECT_TRUE(server.segment(request).ok());
}

TEST(Limits, AQueueFullOfPointsSaysSo) {
  Blockade blockade;
  ServerOptions options = small_server();
  options.max_points = 100;
  options.queue_points = 150;
  RunningServer server(options, blocking_factory(blockade));
  const v1::SegmentRequest request = request_for(equal_points(100, 0, 0, 1));
  grpc::ClientContext first_context;
  auto first = server.segment_later(first_context, request);
  ASSERT_TRUE(eventually([&] { return blockade.entered() == 1; }));

  const absl::Status refused = server.segment(request).status();
  EXPECT_EQ(refused.code(), absl::StatusCode::kResourceExhausted) << refused;
  EXPECT_THAT(
      wire::details_of(refused).metadata,
      testing::UnorderedElementsAre(Pair("limit", "max_queue_points"), Pair("allowed", "150"), Pair("actual", "200")));
  blockade.release();
  EXPECT_TRUE(first.get().ok());
}

TEST(Limits, AClientThatFillsTheQueueMakesWayForAnother) {
  Blockade blockade;
  ServerOptions options = small_server();
  options.queue = 2;
  RunningServer server(options, blocking_factory(blockade));
  const v1::SegmentRequest request = request_for(equal_points(9, 0, 0, 1));
  std::vector<grpc::ClientContext> contexts(3);
  std::vector<std::future<absl::Status>> calls;
  for (std::size_t i = 0; i < 3; ++i) {
    calls.push_back(server.segment_later(contexts[i], request));
    ASSERT_TRUE(eventually([&] { return server.server().calls() == i + 1; }));
  }
  ASSERT_TRUE(eventually([&] { return blockade.entered() == 1; }));

  auto other = std::async(std::launch::async, [&] { return server.segment_from_elsewhere(request); });
  const auto is_over = [](const std::future<absl::Status>& call) {
    return call.wait_for(std::chrono::seconds(0)) == std::future_status::ready;
  };
  EXPECT_TRUE(eventually([&] { return std::ranges::any_of(calls, is_over); }));
  blockade.release();
  EXPECT_TRUE(other.get().ok());
  std::vector<absl::Status> failed;
  for (std::future<absl::Status>& call : calls) {
    if (absl::Status status = call.get(); !status.ok()) failed.push_back(std::move(status));
  }
  ASSERT_EQ(failed.size(), 1U);
  EXPECT_EQ(failed[0].code(), absl::StatusCode::kResourceExhausted) << failed[0];
  EXPECT_EQ(wire::details_of(failed[0]).reason, wire::ErrorReason::kQueueFull);
  EXPECT_TRUE(wire::details_of(failed[0]).retry_delay.has_value());
}

}  // namespace
}  // namespace segserve::server
