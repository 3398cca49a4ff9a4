// SPDX-License-Identifier: Apache-2.0
// Which requests are made, and which are refused before they are sent.
#include "client/calls/request.hpp"

#include <string>

#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "proto/wire/codec_message.hpp"
#include "proto/wire/status_message.hpp"
#include "proto/wire/transport_limits.hpp"
#include "test/client/client_scenes.hpp"

namespace segserve::client {
namespace {

using testing::HasSubstr;

v1::Compression compression_of(const v1::SegmentRequest& request) { return request.cloud().planar().x().compression(); }

bool is_limit_exceeded(const absl::Status& status) {
  return absl::IsInvalidArgument(status) && wire::details_of(status).reason == wire::ErrorReason::kLimitExceeded;
}

TEST(Request, AnOrdinaryFrameIsSentRawUnlessAskedOtherwise) {
  const Cloud frame = flat_cloud(640, 480);
  const auto raw = cloud_request(frame, {}, {});
  ASSERT_TRUE(raw.ok()) << raw.status();
  EXPECT_NE(compression_of(*raw), v1::COMPRESSION_ZSTD);
  const auto compressed = cloud_request(frame, {}, {.compress = Compress::kAlways});
  ASSERT_TRUE(compressed.ok()) << compressed.status();
  EXPECT_EQ(compression_of(*compressed), v1::COMPRESSION_ZSTD);
  EXPECT_LT(compressed->ByteSizeLong(), raw->ByteSizeLong());
}

TEST(Request, ALargeCloudIsCompressedByItself) {
  const auto request = cloud_request(flat_cloud(1000, 700), {}, {});
  ASSERT_TRUE(request.ok()) << request.status();
  EXPECT_EQ(compression_of(*request), v1::COMPRESSION_ZSTD);
  EXPECT_LE(request->ByteSizeLong(), wire::kMaxRequestBytes);
}

TEST(Request, ALargeCloudIsRefusedIfItMustNotBeCompressed) {
  const auto request = cloud_request(flat_cloud(1000, 700), {}, {.compress = Compress::kNever});
  EXPECT_TRUE(is_limit_exceeded(request.status())) << request.status();
  EXPECT_THAT(std::string(request.status().message()), HasSubstr("10500000 bytes"));
}

TEST(Request, NothingAboveTheLimitPasses) {
  // Each point has 15 bytes. Near the limit the few bytes around the planes decide.
  const auto most = static_cast<std::uint32_t>(wire::kMaxRequestBytes / 15);
  for (const std::uint32_t points : {most - 100, most - 1, most, most + 1}) {
    const auto request = cloud_request(incompressible_cloud(points), {}, {.compress = Compress::kNever});
    EXPECT_EQ(request.ok(), points == most - 100) << points;
    EXPECT_EQ(is_limit_exceeded(request.status()), !request.ok()) << request.status();
    const auto compressed = cloud_request(incompressible_cloud(points), {}, {});
    ASSERT_TRUE(compressed.ok()) << compressed.status();
    EXPECT_LE(compressed->ByteSizeLong(), wire::kMaxRequestBytes);
  }
  EXPECT_TRUE(is_limit_exceeded(cloud_request(incompressible_cloud(2 * most), {}, {}).status()));
}

TEST(Request, UsesTheCodecThatIsAskedFor) {
  const auto request =
      cloud_request(flat_cloud(8, 8), {}, {.codec = wire::CodecOptions{wire::Codec::kQuantised, 0.002}});
  ASSERT_TRUE(request.ok()) << request.status();
  EXPECT_TRUE(request->cloud().has_quantised());
  EXPECT_EQ(request->cloud().error_bound(), 0.002);
}

TEST(Request, ACodecIsNotExchangedForAnother) {
  const auto request = cloud_request(flat_cloud(1000, 700), {}, {.codec = wire::CodecOptions{wire::Codec::kStrided}});
  EXPECT_TRUE(is_limit_exceeded(request.status())) << request.status();
}

TEST(Request, APayloadAboveTheLimitIsRefused) {
  const auto file = [](std::size_t bytes) { return pcd_payload(std::string(bytes, ' ')); };
  EXPECT_TRUE(payload_request(file(1000), {}, {}).ok());
  const auto request = payload_request(file(wire::kMaxRequestBytes), {}, {});
  EXPECT_TRUE(is_limit_exceeded(request.status())) << request.status();
}

TEST(Request, PlanesThatDoNotFitEachOtherAreRefused) {
  const Cloud cloud = flat_cloud(8, 8);
  CloudView torn = cloud;
  torn.y = torn.y.first(60);
  EXPECT_TRUE(absl::IsInvalidArgument(cloud_request(torn, {}, {}).status()));
  EXPECT_TRUE(absl::IsInvalidArgument(cloud_request(CloudView{}, {}, {}).status()));
}

TEST(Request, CarriesTheCallersName) {
  const auto request = cloud_request(flat_cloud(8, 8), {}, {.request_id = "robot-7/42"});
  ASSERT_TRUE(request.ok()) << request.status();
  EXPECT_EQ(request->request_id(), "robot-7/42");
}

}  // namespace
}  // namespace segserve::client
