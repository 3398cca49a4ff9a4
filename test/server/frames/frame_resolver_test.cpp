// SPDX-License-Identifier: Apache-2.0
#include "server/frames/frame_resolver.hpp"

#include <chrono>
#include <string>

#include "gmock/gmock.h"
#include "proto/wire/cloud_message.hpp"
#include "proto/wire/payload_blocks.hpp"
#include "proto/wire/request_message.hpp"
#include "proto/wire/status_message.hpp"
#include "test/server/support/server_scenes.hpp"

namespace segserve::server {
namespace {

using namespace std::chrono_literals;
using Time = FrameSettings::Time;
using testing::HasSubstr;

const Time kArrival = Time() + 1h;

v1::SegmentRequest call_with(const v1::Cloud& cloud) {
  v1::SegmentRequest request;
  *request.mutable_cloud() = cloud;
  return request;
}

v1::FrameHeader header_with(v1::Cloud cloud) {
  v1::FrameHeader header;
  header.set_encoded_bytes(wire::payload_bytes(cloud));
  for (std::string* bytes : wire::payload_blocks(cloud)) bytes->clear();
  *header.mutable_cloud() = std::move(cloud);
  return header;
}

v1::Cloud planar(std::uint32_t points) {
  return wire::to_planar_message(equal_points(points, 0, 0, 1), v1::COMPRESSION_NONE).value();
}

v1::Cloud draco() {
  v1::Cloud cloud = planar(9);
  cloud.mutable_draco()->mutable_data()->set_encoded_bytes(0);
  return cloud;
}

/// The settings of the same cloud in a unary call and in a stream.
struct Answers {
  absl::StatusOr<FrameSettings> call, frame;
};
Answers resolve(const ServerOptions& options, const v1::Cloud& cloud) {
  const FrameResolver resolver(options);
  const wire::ParsedRequest stream = resolver.resolve_stream({}).value();
  return {resolver.resolve_call(call_with(cloud), kArrival, std::nullopt),
          resolver.resolve_frame(header_with(cloud), stream, kArrival)};
}

void expect_refused_alike(const Answers& answers, wire::ErrorReason reason, const std::string& text) {
  for (const absl::Status& status : {answers.call.status(), answers.frame.status()}) {
    EXPECT_EQ(status.code(), absl::StatusCode::kInvalidArgument) << status;
    EXPECT_EQ(wire::details_of(status).reason, reason) << status;
    EXPECT_THAT(std::string(status.message()), HasSubstr(text));
  }
  EXPECT_EQ(answers.call.status().message(), answers.frame.status().message());
}

TEST(FrameResolver, GivesCallsAndFramesTheSameSettings) {
  ServerOptions options;
  options.max_points = 1000;
  options.max_decoded_bytes = 20'000;
  options.enable_draco = true;
  options.defaults.voxel_resolution = 0.016;
  const auto [call, frame] = resolve(options, planar(9));
  for (const auto* settings : {&call, &frame}) {
    ASSERT_TRUE(settings->ok()) << settings->status();
    EXPECT_EQ((*settings)->decode_limits.max_points, 1000U);
    EXPECT_EQ((*settings)->decode_limits.max_bytes, 20'000U);
    EXPECT_TRUE((*settings)->decode_limits.draco);
    EXPECT_EQ((*settings)->options.voxel_resolution, 0.016);
    EXPECT_EQ((*settings)->outputs, wire::Outputs());
    EXPECT_EQ((*settings)->arrival, kArrival);
    EXPECT_EQ((*settings)->deadline, std::nullopt);
    EXPECT_EQ((*settings)->estimated_points, 9U);
  }
}

TEST(FrameResolver, RefusesKindsThatAreNotEnabledBeforeThePayloadComes) {
  expect_refused_alike(resolve({}, draco()), wire::ErrorReason::kInvalidField, "cloud.draco: not enabled here");
}

TEST(FrameResolver, RefusesCloudsBeyondTheLimitsBeforeThePayloadComes) {
  ServerOptions options;
  options.max_points = 8;
  expect_refused_alike(resolve(options, planar(9)), wire::ErrorReason::kLimitExceeded, "max_points");
}

TEST(FrameResolver, EstimatesThePointsOfCloudsWithoutAShapeByTheirBytes) {
  const auto [call, frame] = resolve({}, wire::to_pcd_message(std::string(16'000, 'x'), std::nullopt));
  ASSERT_TRUE(call.ok() && frame.ok());
  EXPECT_NEAR(static_cast<double>(call->estimated_points), 1000, 10);
  EXPECT_NEAR(static_cast<double>(frame->estimated_points), 1000, 10);
}

TEST(FrameResolver, KeepsTheThreadsWithinTheServersLimit) {
  ServerOptions options;
  options.threads = 2;
  const FrameResolver resolver(options);
  v1::SegmentRequest request = call_with(planar(9));
  request.mutable_options()->set_threads(16);
  EXPECT_EQ(resolver.resolve_call(request, kArrival, std::nullopt)->options.threads, 2U);
  wire::ParsedRequest stream;
  stream.options.threads = 16;
  EXPECT_EQ(resolver.resolve_frame(header_with(planar(9)), stream, kArrival)->options.threads, 2U);
}

TEST(FrameResolver, AFramesDeadlineIsTheEndOfItsTimeToLive) {
  const FrameResolver resolver{ServerOptions()};
  EXPECT_EQ(resolver.resolve_call(call_with(planar(9)), kArrival, kArrival + 1s)->deadline, kArrival + 1s);
  v1::FrameHeader header = header_with(planar(9));
  header.mutable_time_to_live()->set_seconds(3);
  header.mutable_age()->set_seconds(1);
  EXPECT_EQ(resolver.resolve_frame(header, {}, kArrival)->deadline, kArrival + 2s);
}

}  // namespace
}  // namespace segserve::server
