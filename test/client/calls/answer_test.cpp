// SPDX-License-Identifier: Apache-2.0
// How the client takes answers that a good server does not give.
#include <chrono>
#include <cstdint>
#include <functional>
#include <memory>
#include <string>

#include "fmt/format.h"
#include "gmock/gmock.h"
#include "grpcpp/security/server_credentials.h"
#include "grpcpp/server.h"
#include "grpcpp/server_builder.h"
#include "gtest/gtest.h"
#include "proto/wire/status_message.hpp"
#include "segserve/client/client.hpp"
#include "segserve/v1/segmentation_service.grpc.pb.h"
#include "test/client/client_scenes.hpp"

namespace segserve::client {
namespace {

using testing::HasSubstr;
using v1::SegmentRequest;
using v1::SegmentResponse;

/// Answers every call as the test says.
class ScriptedService final : public v1::SegmentationService::Service {
 public:
  grpc::Status Segment(grpc::ServerContext*, const SegmentRequest*, SegmentResponse* response) override {
    return answer(*response);
  }

  std::function<grpc::Status(SegmentResponse&)> answer;
};

class AnswerTest : public testing::Test {
 protected:
  void SetUp() override {
    int port = 0;
    grpc::ServerBuilder builder;
    builder.AddListeningPort("127.0.0.1:0", grpc::InsecureServerCredentials(), &port);
    builder.RegisterService(&service_);
    server_ = builder.BuildAndStart();
    ASSERT_NE(server_, nullptr);
    address_ = fmt::format("127.0.0.1:{}", port);
  }

  absl::Status call() const { return Client::connect({.address = address_})->segment(flat_cloud(4, 4)).status(); }

  ScriptedService service_;
  std::string address_;
  std::unique_ptr<grpc::Server> server_;
};

/// A summary that fits flat_cloud(4, 4), but no arrays.
void fill_summary(SegmentResponse& response) {
  v1::ResultSummary& summary = *response.mutable_result()->mutable_summary();
  summary.set_points(16);
  summary.set_finite_points(16);
  summary.set_segmented_points(16);
  summary.set_voxels(1);
  summary.set_supervoxels(1);
  summary.set_segments(1);
  summary.set_method(v1::METHOD_COLOR);
  summary.mutable_view()->set_kind(v1::VIEW_KIND_CAMERA);
}

TEST_F(AnswerTest, ABrokenAnswerIsTheServersFault) {
  service_.answer = [](SegmentResponse&) { return grpc::Status::OK; };
  EXPECT_TRUE(absl::IsInternal(call())) << call();

  service_.answer = [](SegmentResponse& response) {
    fill_summary(response);
    response.mutable_result()->mutable_summary()->set_points(17);
    return grpc::Status::OK;
  };
  EXPECT_TRUE(absl::IsInternal(call())) << call();
}

TEST_F(AnswerTest, AClaimOfMorePointsThanAClientAcceptsIsBroken) {
  service_.answer = [](SegmentResponse& response) {
    fill_summary(response);
    auto& summary = *response.mutable_result()->mutable_summary();
    summary.set_points(std::uint64_t{1} << 40);
    summary.set_finite_points(16);
    return grpc::Status::OK;
  };
  const Payload only_the_server_knows_its_size = pcd_payload("bytes that nobody reads");
  const auto result = Client::connect({.address = address_})->segment_payload(only_the_server_knows_its_size);
  EXPECT_TRUE(absl::IsInternal(result.status())) << result.status();
  EXPECT_THAT(std::string(result.status().message()), HasSubstr("claims 1099511627776 points"));
}

TEST_F(AnswerTest, AnAnswerWithoutTheArraysAskedForIsBroken) {
  service_.answer = [](SegmentResponse& response) {
    fill_summary(response);
    return grpc::Status::OK;
  };
  EXPECT_TRUE(absl::IsInternal(call())) << call();
  EXPECT_THAT(std::string(call().message()), HasSubstr("lacks"));
}

TEST_F(AnswerTest, AnAnswerWithoutTheSegmentsAskedForIsBroken) {
  service_.answer = [](SegmentResponse& response) {
    fill_summary(response);
    return grpc::Status::OK;
  };
  const auto client = Client::connect({.address = address_});
  const auto ask = [&](wire::Outputs outputs) {
    return client->segment(flat_cloud(4, 4), {}, {.outputs = outputs}).status();
  };
  EXPECT_TRUE(ask({.labels = false}).ok());
  EXPECT_TRUE(absl::IsInternal(ask({.labels = false, .segments = true})));
}

TEST_F(AnswerTest, TheMessageNamesFieldsThatTheServersMessageDoesNot) {
  service_.answer = [](SegmentResponse&) {
    wire::ErrorDetails details;
    details.reason = wire::ErrorReason::kInvalidField;
    details.fields = {{"options.threshold", "7 is not in [0, 1]"}, {"cloud.width", "is 0"}};
    return wire::to_grpc(wire::with_details(absl::InvalidArgumentError("the request is wrong"), details));
  };
  const absl::Status status = call();
  EXPECT_TRUE(absl::IsInvalidArgument(status)) << status;
  EXPECT_EQ(status.message(), "the request is wrong; options.threshold: 7 is not in [0, 1]; cloud.width: is 0");
  EXPECT_EQ(wire::details_of(status).fields.size(), 2U);
}

TEST_F(AnswerTest, TheMessageSaysWhenToTryAgain) {
  service_.answer = [](SegmentResponse&) {
    wire::ErrorDetails details;
    details.reason = wire::ErrorReason::kQueueFull;
    details.retry_delay = std::chrono::milliseconds(250);
    return wire::to_grpc(wire::with_details(absl::ResourceExhaustedError("64 calls wait"), details));
  };
  const absl::Status status = call();
  EXPECT_TRUE(absl::IsResourceExhausted(status)) << status;
  EXPECT_EQ(status.message(), "64 calls wait (try again in 250 ms)");
  EXPECT_EQ(wire::details_of(status).retry_delay, std::chrono::milliseconds(250));
}

TEST_F(AnswerTest, AServerThatLacksTheMethodIsReported) {
  service_.answer = [](SegmentResponse&) { return grpc::Status(grpc::StatusCode::UNIMPLEMENTED, "no such method"); };
  EXPECT_TRUE(absl::IsUnimplemented(call())) << call();
}

}  // namespace
}  // namespace segserve::client
