// SPDX-License-Identifier: Apache-2.0
#include "proto/wire/cloud_message.hpp"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "gmock/gmock.h"
#include "proto/wire/codec_message.hpp"
#include "proto/wire/payload_blocks.hpp"
#include "proto/wire/status_message.hpp"
#include "segserve/codec/pcd.hpp"
#include "test/proto/example_messages.hpp"

namespace segserve::wire {
namespace {

using testing::HasSubstr;

constexpr codec::DecodeLimits kLimits{.max_points = 100, .max_bytes = 10'000};

bool same_bits(std::span<const float> a, std::span<const float> b) {
  return a.size() == b.size() && std::memcmp(a.data(), b.data(), a.size() * sizeof(float)) == 0;
}

void expect_same(const CloudView& a, const CloudView& b) {
  EXPECT_TRUE(same_bits(a.x, b.x) && same_bits(a.y, b.y) && same_bits(a.z, b.z));
  EXPECT_TRUE(std::ranges::equal(a.rgb, b.rgb));
  EXPECT_EQ(a.width, b.width);
  EXPECT_EQ(a.height, b.height);
  EXPECT_EQ(a.view, b.view);
}

std::vector<std::string> wrong_fields(const v1::Cloud& message) {
  std::vector<std::string> fields;
  for (const FieldViolation& fault : violations(message)) fields.push_back(fault.field);
  return fields;
}

/// Two points that are so far from the origin that they are moved.
Cloud far_away() {
  Cloud cloud;
  cloud.x = {5000, 5001};
  cloud.y = {0, 8};
  cloud.z = {0, 0};
  cloud.width = 2;
  cloud.height = 1;
  return cloud;
}

v1::Cloud planar() { return to_planar_message(small_cloud(), v1::COMPRESSION_NONE).value(); }

ErrorReason reason_of(const v1::Cloud& message, const codec::DecodeLimits& limits = kLimits) {
  return details_of(decode_cloud(message, limits).status()).reason;
}

TEST(WireCloud, PlanarKeepsEveryBit) {
  for (const auto compression : {v1::COMPRESSION_NONE, v1::COMPRESSION_ZSTD}) {
    const v1::Cloud message = to_planar_message(small_cloud(), compression).value();
    const auto decoded = decode_cloud(message, kLimits);
    ASSERT_TRUE(decoded.ok()) << decoded.status();
    expect_same(decoded->cloud, small_cloud());
    EXPECT_THAT(decoded->view_rule, HasSubstr("CAMERA"));
  }
}

TEST(WireCloud, RawCoordinatesStayInTheMessage) {
  const v1::Cloud message = planar();
  const auto decoded = decode_cloud(message, kLimits);
  ASSERT_TRUE(decoded.ok()) << decoded.status();
  EXPECT_EQ(static_cast<const void*>(decoded->cloud->z.data()),
            static_cast<const void*>(message.planar().z().data().data()));
}

TEST(WireCloud, SharedPlanarIsThePlanarMessage) {
  for (const bool color : {false, true}) {
    Cloud cloud = small_cloud();
    if (!color) cloud.rgb.clear();
    const auto shared = std::make_shared<const Cloud>(cloud);
    const OutgoingCloud out = share_planar(shared);
    EXPECT_EQ(static_cast<const void*>(out.bytes->blocks()[0].data()), static_cast<const void*>(shared->x.data()));
    v1::Cloud message = out.message;
    const std::vector<std::string*> data = payload_blocks(message);
    ASSERT_EQ(data.size(), out.bytes->blocks().size());
    for (std::size_t i = 0; i < data.size(); ++i) *data[i] = out.bytes->blocks()[i];
    EXPECT_EQ(message.SerializeAsString(), to_planar_message(cloud, v1::COMPRESSION_NONE).value().SerializeAsString());
  }
}

TEST(WireCloud, BytesThatAreSentKeepTheirCloud) {
  auto cloud = std::make_shared<const Cloud>(small_cloud());
  const std::weak_ptr<const Cloud> watched = cloud;
  std::optional<OutgoingCloud> out = share_planar(std::move(cloud));
  EXPECT_FALSE(watched.expired());
  out.reset();
  EXPECT_TRUE(watched.expired());
}

TEST(WireCloud, PlanarWithoutColorAndWithASensor) {
  Cloud cloud = small_cloud();
  cloud.rgb.clear();
  cloud.view = View::world(1, 2, 3);
  const v1::Cloud message = to_planar_message(cloud, v1::COMPRESSION_ZSTD).value();
  EXPECT_FALSE(message.planar().has_rgb());
  const auto decoded = decode_cloud(message, kLimits);
  ASSERT_TRUE(decoded.ok()) << decoded.status();
  expect_same(decoded->cloud, cloud);
}

TEST(WireCloud, PcdFileHasItsOwnViewUnlessTheMessageOverridesIt) {
  const std::string file = codec::encode_pcd(small_cloud(), {}, codec::PcdEncoding::kBinaryCompressed);
  const v1::Cloud plain = to_pcd_message(file, std::nullopt);
  const auto by_file = decode_cloud(plain, kLimits);
  ASSERT_TRUE(by_file.ok()) << by_file.status();
  expect_same(by_file->cloud, small_cloud());

  const v1::Cloud told = to_pcd_message(file, View::world(0, 0, 5));
  const auto by_request = decode_cloud(told, kLimits);
  ASSERT_TRUE(by_request.ok()) << by_request.status();
  EXPECT_EQ(by_request->cloud->view, View::world(0, 0, 5));
  EXPECT_NE(by_request->view_rule, by_file->view_rule);
}

TEST(WireCloud, NamesEveryWrongFieldAtOnce) {
  v1::Cloud message = planar();
  message.set_width(0);
  message.set_height(0);
  message.clear_view();
  EXPECT_THAT(wrong_fields(message), testing::UnorderedElementsAre("cloud.width", "cloud.height", "cloud.view"));
  EXPECT_EQ(reason_of(message), ErrorReason::kInvalidField);
}

TEST(WireCloud, NeedsAPayload) { EXPECT_THAT(wrong_fields({}), testing::ElementsAre("cloud.payload")); }

TEST(WireCloud, JudgesTheView) {
  v1::Cloud message = planar();
  message.mutable_view()->mutable_sensor()->set_x(1);
  EXPECT_THAT(wrong_fields(message), testing::ElementsAre("cloud.view.sensor"));
  message.mutable_view()->set_kind(v1::VIEW_KIND_WORLD);
  EXPECT_THAT(wrong_fields(message), testing::IsEmpty());
  message.mutable_view()->mutable_sensor()->set_z(NAN);
  EXPECT_THAT(wrong_fields(message), testing::ElementsAre("cloud.view.sensor"));
  message.mutable_view()->set_kind(v1::VIEW_KIND_UNSPECIFIED);
  EXPECT_THAT(wrong_fields(message), testing::ElementsAre("cloud.view.kind"));
  message.mutable_view()->set_kind(static_cast<v1::ViewKind>(9));
  EXPECT_THAT(wrong_fields(message), testing::ElementsAre("cloud.view.kind"));
}

/// The small cloud as two cameras see it.
Cloud seen_by_two() {
  Cloud cloud = small_cloud();
  const auto points = static_cast<std::uint32_t>(cloud.size());
  cloud.view = View::of_cameras({{1, {1, 2, 3}}, {points - 1, {-1, -2, -3}}});
  return cloud;
}

TEST(WireCloud, CarriesTheCamerasOfEveryPayload) {
  const Cloud cloud = seen_by_two();
  for (const Codec codec : {Codec::kPlanar, Codec::kPlanarZstd, Codec::kStrided, Codec::kPcd, Codec::kQuantised}) {
    const auto message = to_message(cloud, {.codec = codec});
    ASSERT_TRUE(message.ok()) << message.status();
    EXPECT_THAT(wrong_fields(*message), testing::IsEmpty());
    const auto decoded = decode_cloud(*message, kLimits);
    ASSERT_TRUE(decoded.ok()) << decoded.status();
    EXPECT_EQ(decoded->cloud->view, cloud.view);
  }
}

TEST(WireCloud, JudgesTheCameras) {
  const auto faults = [](const std::function<void(v1::View&)>& change) {
    v1::Cloud message = to_planar_message(seen_by_two(), v1::COMPRESSION_NONE).value();
    change(*message.mutable_view());
    return wrong_fields(message);
  };
  const auto cameras_are_wrong = testing::ElementsAre("cloud.view.cameras");
  EXPECT_THAT(faults([](v1::View&) {}), testing::IsEmpty());
  EXPECT_THAT(faults([](v1::View& view) { view.mutable_cameras(0)->set_points(2); }), cameras_are_wrong);
  EXPECT_THAT(faults([](v1::View& view) { view.mutable_cameras(0)->set_points(0); }), cameras_are_wrong);
  EXPECT_THAT(faults([](v1::View& view) { view.mutable_cameras(1)->set_points(0xffffffffU); }), cameras_are_wrong);
  EXPECT_THAT(faults([](v1::View& view) { view.mutable_cameras(1)->mutable_sensor()->set_x(INFINITY); }),
              cameras_are_wrong);
  EXPECT_THAT(faults([](v1::View& view) { view.mutable_cameras(1)->clear_sensor(); }),
              testing::ElementsAre("cloud.view.cameras[1].sensor"));
  EXPECT_THAT(faults([](v1::View& view) { view.mutable_sensor()->set_x(1); }), cameras_are_wrong);
  EXPECT_THAT(faults([](v1::View& view) { view.set_kind(v1::VIEW_KIND_CAMERA); }), cameras_are_wrong);
  EXPECT_THAT(faults([](v1::View& view) {
                for (int i = 0; i < 63; ++i) *view.add_cameras() = view.cameras(0);
              }),
              cameras_are_wrong);
}

TEST(WireCloud, CamerasMustFitAPayloadThatTellsItsShapeLate) {
  v1::Cloud message = to_message(seen_by_two(), {.codec = Codec::kPcd}).value();
  message.set_width(0);
  message.set_height(0);
  EXPECT_TRUE(decode_cloud(message, kLimits).ok());
  message.mutable_view()->mutable_cameras(0)->set_points(7);
  EXPECT_THAT(wrong_fields(message), testing::IsEmpty()) << "only the file tells";
  const absl::Status refused = decode_cloud(message, kLimits).status();
  EXPECT_EQ(details_of(refused).reason, ErrorReason::kInvalidField);
  EXPECT_THAT(std::string(refused.message()), HasSubstr("points together, but the cloud has"));
}

TEST(WireCloud, CamerasMoveWithPointsThatAreFarAway) {
  Cloud far = far_away();
  far.view = View::of_cameras({{1, {5000, 0, 1}}, {1, {5000, 8, 1}}});
  const v1::Cloud message = to_message(far, {.codec = Codec::kStrided}).value();
  const auto decoded = decode_cloud(message, kLimits);
  ASSERT_TRUE(decoded.ok()) << decoded.status();
  const Eigen::Vector3d offset = decoded->placement.offset;
  for (std::size_t c = 0; c < 2; ++c) {
    const Eigen::Vector3d moved = decoded->cloud->view.cameras[c].sensor.cast<double>() + offset;
    EXPECT_TRUE(moved.isApprox(far.view.cameras[c].sensor.cast<double>())) << moved.transpose();
  }
  EXPECT_EQ(codec::to_file(decoded->placement, decoded->cloud->view), far.view);
}

TEST(WireCloud, RefusesPlanesOfAnotherLengthByName) {
  v1::Cloud message = planar();
  message.mutable_planar()->mutable_y()->mutable_data()->pop_back();
  EXPECT_EQ(reason_of(message), ErrorReason::kMalformedPayload);
  EXPECT_THAT(decode_cloud(message, kLimits).status().ToString(), HasSubstr("cloud.planar.y"));

  message = planar();
  message.mutable_planar()->clear_z();
  EXPECT_THAT(decode_cloud(message, kLimits).status().ToString(), HasSubstr("cloud.planar.z"));
}

TEST(WireCloud, ShapeWhoseProductOverflowsIsOverTheLimit) {
  v1::Cloud message = planar();
  message.set_width(0xffffffff);
  message.set_height(0xffffffff);
  EXPECT_EQ(reason_of(message), ErrorReason::kLimitExceeded);
}

TEST(WireCloud, LimitsAreNamedWithTheirValues) {
  const v1::Cloud message = planar();
  const absl::Status points = decode_cloud(message, {.max_points = 5, .max_bytes = 10'000}).status();
  EXPECT_EQ(points.code(), absl::StatusCode::kInvalidArgument);
  EXPECT_THAT(details_of(points).metadata,
              testing::UnorderedElementsAre(testing::Pair("limit", "max_points"), testing::Pair("allowed", "5"),
                                            testing::Pair("actual", "6")));
  const absl::Status bytes = decode_cloud(message, {.max_points = 6, .max_bytes = 6 * 15 - 1}).status();
  EXPECT_THAT(details_of(bytes).metadata, testing::Contains(testing::Pair("limit", "max_decoded_bytes")));
  EXPECT_TRUE(decode_cloud(message, {.max_points = 6, .max_bytes = 6 * 15}).ok());
}

TEST(WireCloud, PcdFileWithTooManyPointsExceedsTheLimit) {
  const std::string file = codec::encode_pcd(small_cloud(), {}, codec::PcdEncoding::kBinary);
  EXPECT_EQ(reason_of(to_pcd_message(file, std::nullopt), {.max_points = 5, .max_bytes = 10'000}),
            ErrorReason::kLimitExceeded);
}

TEST(WireCloud, TruncatedPcdIsMalformed) {
  const std::string file = codec::encode_pcd(small_cloud(), {}, codec::PcdEncoding::kBinary);
  EXPECT_EQ(reason_of(to_pcd_message(file.substr(0, file.size() - 1), std::nullopt)), ErrorReason::kMalformedPayload);
  EXPECT_EQ(reason_of(to_pcd_message("", std::nullopt)), ErrorReason::kMalformedPayload);
}

TEST(WireCloud, ShapeOfARequestMustAgreeWithThePcdFile) {
  const std::string file = codec::encode_pcd(small_cloud(), {}, codec::PcdEncoding::kBinary);
  v1::Cloud message = to_pcd_message(file, std::nullopt);
  message.set_width(3);
  message.set_height(2);
  EXPECT_TRUE(decode_cloud(message, kLimits).ok());
  message.set_height(3);
  EXPECT_EQ(reason_of(message), ErrorReason::kInvalidField);
}

TEST(WireCloud, CoordinatesInAnotherUnitBecomeMeters) {
  Cloud millimeters = small_cloud();
  millimeters.view = View::world(0, 0, 2);
  for (const auto& encode : {CodecOptions{}, CodecOptions{.codec = Codec::kPlanarZstd},
                             CodecOptions{.codec = Codec::kStrided}, CodecOptions{.codec = Codec::kPcd}}) {
    v1::Cloud message = to_message(millimeters, encode).value();
    message.set_unit(v1::LENGTH_UNIT_MILLIMETER);
    const auto decoded = decode_cloud(message, kLimits);
    ASSERT_TRUE(decoded.ok()) << decoded.status();
    EXPECT_EQ(decoded->placement.meters_per_unit(), 0.001);
    for (std::size_t i = 0; i < millimeters.size(); ++i) {
      if (!std::isfinite(millimeters.x[i])) continue;
      EXPECT_FLOAT_EQ(decoded->cloud->x[i], 0.001F * millimeters.x[i]);
    }
    EXPECT_EQ(decoded->cloud->view, millimeters.view) << "the view of a message is in meters";
  }
}

TEST(WireCloud, UnitsAreChecked) {
  v1::Cloud unknown = planar();
  unknown.set_unit(static_cast<v1::LengthUnit>(77));
  EXPECT_THAT(wrong_fields(unknown), testing::ElementsAre("cloud.unit"));
  v1::Cloud images;
  images.mutable_rgbd();
  images.set_unit(v1::LENGTH_UNIT_METER);
  EXPECT_THAT(wrong_fields(images), testing::ElementsAre("cloud.unit"));
  for (const codec::LengthUnit unit : codec::length_units()) EXPECT_EQ(from_message(to_message(unit)), unit);
  EXPECT_EQ(from_message(to_message(codec::LengthUnit::kAuto)), codec::LengthUnit::kAuto);
}

}  // namespace
}  // namespace segserve::wire
