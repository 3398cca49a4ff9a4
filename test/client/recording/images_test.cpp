// SPDX-License-Identifier: Apache-2.0
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <bit>
#include <cmath>
#include <cstring>
#include <string>
#include <vector>

#include "client/recording/images/image_messages.hpp"
#include "client/recording/images/recorded_color.hpp"
#include "client/recording/images/recorded_depth.hpp"
#include "client/recording/topic/rgbd_frames.hpp"
#include "core/codec/rgbd/png_image.hpp"
#include "test/client/recording/recording_files.hpp"

namespace segserve::recording {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using std::string_view_literals::operator""sv;

RawImage raw(std::string encoding, std::uint32_t width, std::uint32_t step, std::string_view data) {
  RawImage image;
  image.width = width;
  image.height = static_cast<std::uint32_t>(data.size() / step);
  image.encoding = std::move(encoding);
  image.step = step;
  image.data = data;
  return image;
}

TEST(DepthImage, SixteenBitsAreMillimetersInEitherByteOrder) {
  RawImage image = raw("16UC1", 2, 5, "\xe8\x03\x00\x00.\xff\xff\x01\x00."sv);
  auto depth = decode_depth(image, {}, {});
  ASSERT_TRUE(depth.ok()) << depth.status();
  EXPECT_EQ(depth->meters[0], 1.0F);
  EXPECT_TRUE(std::isnan(depth->meters[1])) << "0 is no depth";
  EXPECT_TRUE(std::isnan(depth->meters[2])) << "65535 is no depth";
  EXPECT_EQ(depth->largest, 1U);
  EXPECT_EQ(depth->meters[3], 0.001F);
  image.is_bigendian = true;
  depth = decode_depth(image, {}, {});
  EXPECT_EQ(depth->meters[0], static_cast<float>(0xe803 * 0.001));
}

TEST(DepthImage, FloatsAreMeters) {
  const std::vector<float> values{1.5F, 0, -1, INFINITY};
  const std::string_view data(reinterpret_cast<const char*>(values.data()), 16);
  const auto depth = decode_depth(raw("32FC1", 4, 16, data), {}, {});
  ASSERT_TRUE(depth.ok());
  EXPECT_EQ(depth->meters[0], 1.5F);
  for (std::size_t i = 1; i < 4; ++i) EXPECT_TRUE(std::isnan(depth->meters[i])) << i;
}

TEST(DepthImage, ClaimsBeyondTheBytesAndOtherEncodingsAreRefused) {
  RawImage image = raw("16UC1", 2, 4, "12341234");
  image.height = 3;
  EXPECT_THAT(std::string(decode_depth(image, {}, {}).status().message()), HasSubstr("too few for 3 rows"));
  image.height = 0xFFFFFFFF;
  image.width = 0xFFFFFFFF;
  EXPECT_FALSE(decode_depth(image, {}, {}).ok());
  EXPECT_THAT(std::string(decode_depth(raw("rgb8", 1, 3, "123"), {}, {}).status().message()),
              HasSubstr("'rgb8' is no depth image"));
}

TEST(DepthImage, PngsAreReadAloneAndBehindTheHeaderOfCompressedDepth) {
  const std::vector<std::uint16_t> pixels{1000, 0};
  const std::string png = *codec::encode_png_gray16({2, 1}, pixels);
  CompressedImage image;
  image.data = png;
  EXPECT_EQ(decode_depth(image, {}, {})->meters[0], 1.0F);
  const std::string behind = std::string(12, '\0') + png;
  image.data = behind;
  image.format = "16UC1; compressedDepth png";
  EXPECT_EQ(decode_depth(image, {}, {})->meters[0], 1.0F);

  std::string inverse(4, '\0');
  for (const float value : {2000.0F, 200.0F}) inverse += std::string(reinterpret_cast<const char*>(&value), 4);
  inverse += png;
  image.data = inverse;
  image.format = "32FC1; compressedDepth png";
  const auto depth = decode_depth(image, {}, {});
  EXPECT_EQ(depth->meters[0], 2.5F) << "2000 / (1000 - 200)";
  EXPECT_TRUE(std::isnan(depth->meters[1]));
  image.data = "no image";
  EXPECT_FALSE(decode_depth(image, {}, {}).ok());
}

TEST(ColorImage, ChannelsAreTakenFromWhereTheyAre) {
  const auto rgb = [](const char* encoding, std::string_view data) {
    return decode_color(raw(encoding, 1, static_cast<std::uint32_t>(data.size()), data), {})->rgb;
  };
  EXPECT_THAT(rgb("rgb8", "\1\2\3"), ElementsAre(1, 2, 3));
  EXPECT_THAT(rgb("bgr8", "\1\2\3"), ElementsAre(3, 2, 1));
  EXPECT_THAT(rgb("rgba8", "\1\2\3\4"), ElementsAre(1, 2, 3));
  EXPECT_THAT(rgb("bgra8", "\1\2\3\4"), ElementsAre(3, 2, 1));
  EXPECT_THAT(rgb("mono8", "\5"), ElementsAre(5, 5, 5));
  EXPECT_FALSE(decode_color(raw("bayer_rggb8", 1, 1, "x"), {}).ok());
  RawImage large = raw("rgb8", 1, 3, "123");
  large.width = 2;
  EXPECT_FALSE(decode_color(large, {}).ok());
}

KeptMessage kept(std::int64_t stamp) { return {{MessageKind::kRawImage, MessageEncoding::kCdr}, {}, "", stamp}; }

/// The stamp of the color that a depth image gets; -1: none.
std::int64_t color_of(ImagePairing& pairing) {
  const auto pair = pairing.take();
  return pair && pair->color ? pair->color->stamp : -1;
}

TEST(ImagePairing, TheNearestColorIsTaken) {
  ImagePairing pairing(true);
  pairing.add_color(kept(100));
  pairing.add_depth(kept(130));
  EXPECT_FALSE(pairing.take()) << "a nearer one may come";
  pairing.add_color(kept(140));
  EXPECT_EQ(color_of(pairing), 140);
  pairing.add_depth(kept(115));
  EXPECT_EQ(color_of(pairing), 100);
}

TEST(ImagePairing, ImagesFarApartAreNoPair) {
  ImagePairing pairing(true);
  pairing.add_color(kept(0));
  pairing.add_depth(kept(static_cast<std::int64_t>(ImagePairing::kLargestGap) + 1));
  EXPECT_FALSE(pairing.take());
  pairing.finish();
  const auto pair = pairing.take();
  ASSERT_TRUE(pair);
  EXPECT_FALSE(pair->color);
}

TEST(ImagePairing, WaitingEndsWhenTooManyWait) {
  ImagePairing pairing(true);
  for (std::size_t i = 0; i < ImagePairing::kMostWaiting; ++i) pairing.add_depth(kept(10));
  EXPECT_FALSE(pairing.take());
  pairing.add_depth(kept(10));
  EXPECT_TRUE(pairing.take());
}

TEST(ImagePairing, WithoutColorsNothingWaits) {
  ImagePairing pairing(false);
  pairing.add_depth(kept(10));
  EXPECT_TRUE(pairing.take());
}

/// A message Image in CDR.
std::string image_message(std::uint32_t width, std::string_view encoding, std::string_view data) {
  RosWriter writer(RosWire::kCdr);
  write_header({0, 1'000'000'005, "camera_depth_optical_frame"}, RosWire::kCdr, writer);
  const std::uint32_t step = width * (encoding == "rgb8" ? 3 : 2);
  writer.number(static_cast<std::uint32_t>(data.size() / step));
  writer.number(width);
  writer.string(encoding);
  writer.number(std::uint8_t{0});
  writer.number(step);
  writer.octets(data);
  return writer.take();
}

TEST(ReadPair, MakesACameraCloudByTheIntrinsics) {
  const MessageType type{MessageKind::kRawImage, MessageEncoding::kCdr};
  const std::string depth = image_message(2, "16UC1", "\xe8\x03\xd0\x07"sv);
  const std::string color = image_message(2, "rgb8", "\1\2\3\4\5\6"sv);
  const ImagePair pair{{type, {}, depth, 0}, KeptMessage{type, {}, color, 0}};
  CameraInfo camera;
  camera.width = 2;
  camera.height = 1;
  camera.k = {2, 0, 0.5, 0, 4, 1, 0, 0, 1};
  camera.p = {10, 0, 0.5, 0, 0, 10, 1, 0, 0, 0, 1, 0};
  client::TopicFrame frame;
  read_pair(pair, camera, false, {.color_topic = "/color"}, {}, frame);
  ASSERT_TRUE(frame.content.ok()) << frame.content.status();
  const Cloud& cloud = frame.content->cloud;
  EXPECT_THAT(cloud.x, ElementsAre(-0.25F, 0.5F));
  EXPECT_THAT(cloud.y, ElementsAre(-0.25F, -0.5F));
  EXPECT_THAT(cloud.z, ElementsAre(1.0F, 2.0F));
  EXPECT_THAT(cloud.rgb, ElementsAre(0x010203, 0x040506));
  EXPECT_EQ(cloud.view, View::camera());
  EXPECT_EQ(frame.frame_id, "camera_depth_optical_frame");
  EXPECT_EQ(frame.stamp.time_since_epoch().count(), 1'000'000'005);
  EXPECT_THAT(frame.content->warnings, testing::IsEmpty());

  read_pair(pair, camera, true, {}, {}, frame);
  EXPECT_THAT(frame.content->cloud.x, ElementsAre(-0.05F, 0.1F)) << "P is for rectified images";
  camera.distortion = {0, 0.1};
  read_pair({pair.depth, std::nullopt}, camera, false, {.color_topic = "/color"}, {}, frame);
  ASSERT_EQ(frame.content->warnings.size(), 2U);
  EXPECT_THAT(frame.content->warnings[0].message, HasSubstr("distorted lens"));
  EXPECT_THAT(frame.content->warnings[1].message, HasSubstr("no color image within"));
  camera.width = 4;
  read_pair(pair, camera, false, {}, {}, frame);
  EXPECT_THAT(std::string(frame.content.status().message()),
              HasSubstr("for 4 x 1 pixels, but the depth image has 2 x 1"));
}

}  // namespace
}  // namespace segserve::recording
