// SPDX-License-Identifier: Apache-2.0
#include "proto/wire/codec_message.hpp"

#include <atomic>
#include <cmath>
#include <cstdint>
#include <optional>
#include <random>
#include <string>
#include <vector>

#include "gmock/gmock.h"
#include "proto/wire/cloud_message.hpp"
#include "proto/wire/payload_blocks.hpp"
#include "proto/wire/status_message.hpp"
#include "segserve/codec/draco.hpp"
#include "test/proto/example_messages.hpp"

namespace segserve::wire {
namespace {

using testing::Contains;
using testing::HasSubstr;
using testing::Not;

constexpr codec::DecodeLimits kAll{.max_points = 100'000, .max_bytes = 4'000'000, .draco = true};
constexpr double kBound = 0.001;

/// An organized cloud of a pinhole camera. Depth and color are random, so that a codec that lost the order of the
/// points could not restore it. About every sixth point is not finite.
Cloud frame(bool color, std::uint32_t width = 24, std::uint32_t height = 18) {
  std::mt19937 random(7);
  Cloud cloud;
  cloud.resize(std::size_t{width} * height, color);
  cloud.width = width;
  cloud.height = height;
  cloud.view = View::camera();
  for (std::uint32_t v = 0, i = 0; v < height; ++v) {
    for (std::uint32_t u = 0; u < width; ++u, ++i) {
      const float z = random() % 6 == 0 ? NAN : 0.5F + static_cast<float>(random() % 3000) / 1000;
      cloud.x[i] = (static_cast<float>(u) - 11.5F) / 30 * z;
      cloud.y[i] = (static_cast<float>(v) - 8.5F) / 30 * z;
      cloud.z[i] = z;
      if (color) cloud.rgb[i] = random() & 0xFFFFFFU;
    }
  }
  return cloud;
}

class EachCodec : public testing::TestWithParam<CodecInfo> {
 protected:
  v1::Cloud encode(const CloudView& cloud) const {
    const auto message = to_message(cloud, {.codec = GetParam().codec, .error_bound = kBound});
    EXPECT_TRUE(message.ok()) << message.status();
    return message.value_or(v1::Cloud());
  }
};

TEST_P(EachCodec, PointsComeBackInTheirOrder) {
  for (const bool color : {false, true}) {
    const Cloud cloud = frame(color);
    const v1::Cloud message = encode(cloud);
    const auto decoded = decode_cloud(message, kAll);
    ASSERT_TRUE(decoded.ok()) << decoded.status();
    const CloudView& got = decoded->cloud;
    ASSERT_EQ(got.size(), cloud.size());
    EXPECT_EQ(got.width, cloud.width);
    EXPECT_EQ(got.height, cloud.height);
    EXPECT_EQ(got.view, cloud.view);
    EXPECT_EQ(got.has_color(), color);
    // Neighbors differ by much more than the bound, so a point in the place of another one is noticed.
    const double bound = GetParam().is_lossless ? 0 : message.error_bound();
    for (std::size_t i = 0; i < cloud.size(); ++i) {
      const bool finite = is_finite(cloud.x[i], cloud.y[i], cloud.z[i]);
      ASSERT_EQ(is_finite(got.x[i], got.y[i], got.z[i]), finite) << "point " << i;
      if (!finite) continue;
      ASSERT_NEAR(got.x[i], cloud.x[i], bound) << "point " << i;
      ASSERT_NEAR(got.y[i], cloud.y[i], bound) << "point " << i;
      ASSERT_NEAR(got.z[i], cloud.z[i], bound) << "point " << i;
      if (color && GetParam().codec != Codec::kRgbd) {  // JPEG does not keep random colors.
        ASSERT_EQ(got.rgb[i], cloud.rgb[i]) << "point " << i;
      }
    }
  }
}

TEST_P(EachCodec, ALossyMessageDeclaresItsBound) {
  const v1::Cloud message = encode(frame(true));
  if (GetParam().is_lossless) {
    EXPECT_EQ(message.error_bound(), 0);
  } else {
    EXPECT_GT(message.error_bound(), 0);
    EXPECT_LE(message.error_bound(), kBound);
  }
}

TEST_P(EachCodec, WorldCloudsWithASensorKeepTheirView) {
  if (GetParam().codec == Codec::kRgbd) return;
  Cloud cloud = frame(true);
  cloud.view = View::world(1, 2, 3);
  const v1::Cloud message = encode(cloud);
  const auto decoded = decode_cloud(message, kAll);
  ASSERT_TRUE(decoded.ok()) << decoded.status();
  EXPECT_EQ(decoded->cloud->view, cloud.view);
}

TEST_P(EachCodec, BlocksTellTheirSizes) {
  v1::Cloud message = encode(frame(true));
  const std::vector<std::uint64_t> sizes = payload_block_sizes(message);
  const std::vector<std::string*> data = payload_blocks(message);
  ASSERT_EQ(sizes.size(), data.size());
  ASSERT_FALSE(sizes.empty());
  for (std::size_t i = 0; i < sizes.size(); ++i) EXPECT_EQ(sizes[i], data[i]->size());
}

/// Truncates every block at every byte, which must be refused, and changes every byte, which must be refused or decoded
/// within the limits.
TEST_P(EachCodec, DamageIsRefusedOrDecodedWithinBounds) {
  const v1::Cloud good = encode(small_camera_cloud());
  constexpr codec::DecodeLimits kFew{.max_points = 1000, .max_bytes = 100'000, .draco = true};
  ASSERT_TRUE(decode_cloud(good, kFew).ok());
  v1::Cloud message = good;
  for (std::string* data : payload_blocks(message)) {
    const std::string whole = *data;
    for (std::size_t at = 0; at < whole.size(); ++at) {
      for (const int change : {0x01, 0x40, 0xff}) {
        *data = whole;
        (*data)[at] = static_cast<char>((*data)[at] ^ change);
        const auto decoded = decode_cloud(message, kFew);
        if (decoded.ok()) continue;
        ASSERT_EQ(decoded.status().code(), absl::StatusCode::kInvalidArgument) << decoded.status();
        ASSERT_NE(details_of(decoded.status()).reason, ErrorReason::kUnspecified);
      }
      *data = whole.substr(0, at);
      ASSERT_EQ(decode_cloud(message, kFew).status().code(), absl::StatusCode::kInvalidArgument) << at;
    }
    *data = whole;
  }
}

TEST_P(EachCodec, AStoppedDecodingEndsSoon) {
  const Cloud cloud = frame(true, 400, 300);
  const v1::Cloud message = encode(cloud);
  constexpr codec::DecodeLimits kEnough{.draco = true};
  WorkMeter whole;
  ASSERT_TRUE(decode_cloud(message, kEnough, StopToken(nullptr, std::nullopt, &whole)).ok());
  EXPECT_GE(whole.units(), cloud.size());
  for (const std::uint64_t at : {std::uint64_t{0}, whole.units() / 3, whole.units() * 2 / 3}) {
    std::atomic<bool> cancelled = false;
    std::uint64_t before = 0;
    WorkMeter meter([&](std::uint64_t units) {
      if (cancelled || units < at) return;
      before = units;
      cancelled = true;
    });
    const auto decoded = decode_cloud(message, kEnough, StopToken(&cancelled, std::nullopt, &meter));
    EXPECT_EQ(decoded.status().code(), absl::StatusCode::kCancelled) << at << " of " << whole.units();
    EXPECT_EQ(details_of(decoded.status()).reason, ErrorReason::kUnspecified) << "the payload is not at fault";
    EXPECT_LE(meter.units() - before, StopToken::kMostWorkAfterStop) << at << " of " << whole.units();
  }
  const StopToken late(nullptr, StopToken::Clock::now());
  EXPECT_EQ(decode_cloud(message, kEnough, late).status().code(), absl::StatusCode::kDeadlineExceeded);
}

INSTANTIATE_TEST_SUITE_P(Codecs, EachCodec, testing::ValuesIn(codecs().begin(), codecs().end()),
                         [](const auto& parameter) {
                           std::string name(parameter.param.name);
                           std::erase(name, '-');
                           return name;
                         });

TEST(WireCodec, NamesAreUniqueAndFound) {
  for (const CodecInfo& entry : codecs()) {
    EXPECT_EQ(codec_from_name(entry.name).value(), entry.codec);
    EXPECT_EQ(info(entry.codec).name, entry.name);
  }
  EXPECT_THAT(codec_from_name("gzip").status().ToString(), HasSubstr("no codec 'gzip'; there are planar, planar-zstd"));
}

TEST(WireCodec, DracoIsRefusedUnlessEnabled) {
  constexpr codec::DecodeLimits kDefault{};
  EXPECT_THAT(accepted_kinds(kDefault), Not(Contains(v1::PAYLOAD_KIND_DRACO)));
  v1::Cloud message;
  message.mutable_draco();
  message.set_width(1);
  message.set_height(1);
  *message.mutable_view() = to_message(View::camera());
  for (const absl::Status& status : {check_kind(message, kDefault), decode_cloud(message, kDefault).status()}) {
    EXPECT_EQ(status.code(), absl::StatusCode::kInvalidArgument);
    EXPECT_EQ(details_of(status).reason, ErrorReason::kInvalidField);
    EXPECT_THAT(std::string(status.message()),
                HasSubstr("cloud.draco: not enabled here; enabled are planar, pcd_file, strided, quantised, rgbd"));
  }
  if (!codec::draco_is_built()) GTEST_SKIP() << "built without Draco";
  EXPECT_THAT(accepted_kinds(kAll), Contains(v1::PAYLOAD_KIND_DRACO));
  EXPECT_TRUE(check_kind(message, kAll).ok());
}

std::vector<std::string> wrong_fields(const v1::Cloud& message) {
  std::vector<std::string> fields;
  for (const FieldViolation& fault : violations(message)) fields.push_back(fault.field);
  return fields;
}

TEST(WireCodec, EachPayloadSaysWhatItNeedsAroundIt) {
  v1::Cloud message;
  message.mutable_strided();
  EXPECT_THAT(wrong_fields(message), testing::ElementsAre("cloud.view", "cloud.width", "cloud.height"));
  message.mutable_draco();
  EXPECT_THAT(wrong_fields(message), testing::ElementsAre("cloud.view", "cloud.width", "cloud.height"));
  message.mutable_quantised();
  EXPECT_THAT(wrong_fields(message), testing::ElementsAre("cloud.view", "cloud.error_bound"));
  message.set_error_bound(NAN);
  message.mutable_rgbd();
  EXPECT_THAT(wrong_fields(message), testing::ElementsAre("cloud.error_bound"));
  message.set_error_bound(0);
  EXPECT_THAT(wrong_fields(message), testing::IsEmpty());
  *message.mutable_view() = to_message(View::world());
  EXPECT_THAT(wrong_fields(message), testing::ElementsAre("cloud.view.kind"));
}

TEST(WireCodec, RefusesAMessageThatContradictsItsPayload) {
  v1::Cloud message = to_message(frame(true), {.codec = Codec::kQuantised, .error_bound = kBound}).value();
  message.set_error_bound(0.002);
  EXPECT_THAT(decode_cloud(message, kAll).status().ToString(),
              HasSubstr("cloud.error_bound: the message says 0.002 m, but the quantised cloud has 0.001 m"));
  message.set_error_bound(kBound);
  message.set_width(25);
  EXPECT_THAT(decode_cloud(message, kAll).status().ToString(),
              HasSubstr("cloud.width: the message says 25 x 18, but the quantised cloud has 24 x 18"));
  message = to_message(frame(true), {.codec = Codec::kRgbd}).value();
  message.set_height(1);
  EXPECT_THAT(decode_cloud(message, kAll).status().ToString(),
              HasSubstr("the message says 24 x 1, but the depth image has 24 x 18"));
  message.set_height(18);
  message.mutable_rgbd()->set_fx(0);
  EXPECT_THAT(decode_cloud(message, kAll).status().ToString(), HasSubstr("fx is 0"));
}

TEST(WireCodec, ImagesCarryTheCameraOfTheColorsAndTheirWarnings) {
  codec::RgbdFiles files{.depth = std::string("P5 2 1 65535 \x03\xe8\xff\xff", 17),
                         .color = "P6 1 1 255 abc",
                         .depth_scale = 0.001,
                         .intrinsics = {.fx = 1, .fy = 1},
                         .color_intrinsics = codec::Intrinsics{.fx = 1, .fy = 1, .cx = -7}};
  const v1::Cloud message = to_rgbd_message(files);
  EXPECT_EQ(message.width(), 2U);
  EXPECT_EQ(message.rgbd().color_intrinsics().cx(), -7);
  const auto decoded = decode_cloud(message, kAll);
  ASSERT_TRUE(decoded.ok()) << decoded.status();
  ASSERT_EQ(decoded->warnings.size(), 2U);
  EXPECT_EQ(decoded->warnings[0].reason, codec::WarningReason::kPointsNotUsed);
  EXPECT_EQ(decoded->warnings[1].reason, codec::WarningReason::kColorMissing);
  files.color_intrinsics.reset();
  EXPECT_FALSE(to_rgbd_message(files).rgbd().has_color_intrinsics());
}

}  // namespace
}  // namespace segserve::wire
