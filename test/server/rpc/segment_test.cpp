// SPDX-License-Identifier: Apache-2.0
#include <string>

#include "gmock/gmock.h"
#include "proto/wire/codec_message.hpp"
#include "proto/wire/options_message.hpp"
#include "proto/wire/result_message.hpp"
#include "segserve/codec/draco.hpp"
#include "segserve/codec/pcd.hpp"
#include "test/server/support/running_server.hpp"
#include "test/server/support/server_scenes.hpp"

namespace segserve::server {
namespace {

constexpr wire::Outputs kEverything{
    .labels = true, .supervoxels = true, .tree = true, .segments = true, .compression = wire::Compression::kZstd};

/// The server's answer, converted to core's types.
wire::Result ask(RunningServer& server, v1::SegmentRequest request, std::size_t points) {
  *request.mutable_outputs() = wire::to_message(kEverything);
  const auto response = server.segment(request);
  EXPECT_TRUE(response.ok()) << response.status();
  const auto result = wire::from_message(response.value().result(), points);
  EXPECT_TRUE(result.ok()) << result.status();
  return result.value();
}

void expect_equal(const Segmentation& remote, const Segmentation& local) {
  EXPECT_EQ(remote.labels, local.labels);
  EXPECT_EQ(remote.supervoxels, local.supervoxels);
  EXPECT_EQ(remote.tree, local.tree);
  EXPECT_EQ(remote.segments, local.segments);
  EXPECT_EQ(remote.finite_points, local.finite_points);
  EXPECT_EQ(remote.segmented_points, local.segmented_points);
  EXPECT_EQ(remote.support_plane, local.support_plane);
  EXPECT_EQ(remote.voxels, local.voxels);
  EXPECT_EQ(remote.lambda, local.lambda);
}

TEST(Segment, EveryPayloadGivesTheLabelsOfALocalRun) {
  RunningServer server;
  const Cloud cloud = wall_with_box();
  const Segmentation local = segment(cloud, {}).value();
  ASSERT_GE(local.segments, 2U) << "a scene that tests something";
  const std::vector<v1::SegmentRequest> requests = {
      request_for(cloud, v1::COMPRESSION_NONE),
      request_for(cloud, v1::COMPRESSION_ZSTD),
      request_for_pcd(codec::encode_pcd(cloud, {}, codec::PcdEncoding::kAscii)),
      request_for_pcd(codec::encode_pcd(cloud, {}, codec::PcdEncoding::kBinary)),
      request_for_pcd(codec::encode_pcd(cloud, {}, codec::PcdEncoding::kBinaryCompressed)),
  };
  for (const v1::SegmentRequest& request : requests) {
    SCOPED_TRACE(request.cloud().payload_case());
    expect_equal(ask(server, request, cloud.size()).segmentation, local);
  }
}

/// Labels come in the order of the points that were sent, with points that are not finite in between.
TEST(Segment, EveryCodecGivesTheLabelsOfALocalRunOnTheDecodedPayload) {
  ServerOptions options = small_server();
  options.enable_draco = true;
  RunningServer server(options);
  const Cloud cloud = wall_with_box();
  for (const wire::CodecInfo& codec : wire::codecs()) {
    SCOPED_TRACE(codec.name);
    v1::SegmentRequest request;
    *request.mutable_cloud() = wire::to_message(cloud, {.codec = codec.codec}).value();
    const wire::DecodedCloud decoded = wire::decode_cloud(request.cloud(), {.draco = true}).value();
    const Segmentation local = segment(decoded.cloud, {}).value();
    ASSERT_GE(local.segments, 2U);
    const wire::Result result = ask(server, request, cloud.size());
    expect_equal(result.segmentation, local);
    for (std::size_t i = 0; i < cloud.size(); ++i) {
      const bool finite = is_finite(cloud.x[i], cloud.y[i], cloud.z[i]);
      ASSERT_EQ(result.segmentation.labels[i] != 0, finite) << "point " << i;
    }
  }
}

TEST(Segment, DracoIsRefusedUnlessTheServerEnablesIt) {
  if (!codec::draco_is_built()) GTEST_SKIP() << "built without Draco";
  RunningServer server;
  v1::SegmentRequest request;
  *request.mutable_cloud() = wire::to_message(wall_with_box(), {.codec = wire::Codec::kDraco}).value();
  const absl::Status status = server.segment(request).status();
  EXPECT_EQ(status.code(), absl::StatusCode::kInvalidArgument);
  EXPECT_THAT(std::string(status.message()), testing::HasSubstr("cloud.draco: not enabled here; enabled are planar"));
}

TEST(Segment, EveryMethodAndCutGivesTheLabelsOfALocalRun) {
  RunningServer server;
  const Cloud cloud = wall_with_box();
  for (const Method method : all_methods()) {
    Options options;
    options.method = method;
    if (method == Method::kColor) options.regions = 3;
    if (method == Method::kFixedLambda) options.threshold = 0.3;
    v1::SegmentRequest request = request_for(cloud);
    *request.mutable_options() = wire::to_message(options);
    const wire::Result result = ask(server, request, cloud.size());
    SCOPED_TRACE(name(method));
    expect_equal(result.segmentation, segment(cloud, options).value());
    EXPECT_EQ(result.method, method);
    EXPECT_EQ(result.regions, options.regions);
    EXPECT_EQ(result.options_hash, wire::options_hash(options));
    EXPECT_EQ(result.segmentation.threshold.has_value(), !options.regions.has_value());
  }
}

TEST(Segment, DescribesTheSegmentsOfWhatItDecoded) {
  RunningServer server;
  const Cloud cloud = wall_with_box();
  for (const wire::Codec codec : {wire::Codec::kPlanar, wire::Codec::kQuantised}) {
    v1::SegmentRequest request;
    *request.mutable_cloud() = wire::to_message(cloud, {.codec = codec}).value();
    const wire::DecodedCloud decoded = wire::decode_cloud(request.cloud(), {}).value();
    Segmentation local = segment(decoded.cloud, {}).value();
    ASSERT_TRUE(describe(decoded.cloud, 1, {}, local).ok());
    ASSERT_GE(local.statistics.size(), 2U);
    const wire::Result result = ask(server, request, cloud.size());
    EXPECT_EQ(result.segmentation.statistics, local.statistics);
    EXPECT_GT(result.segmentation.timings.segments, 0);
  }
}

TEST(Segment, LeavesOutWhatTheOptionsSay) {
  RunningServer server;
  const Cloud cloud = wall_with_box();
  for (const Options& options : {Options{.crop_max_x = 0.1}, Options{.range_max = 1.3}, Options{.crop_min_z = 1},
                                 Options{.support_plane_distance = 0.01}}) {
    v1::SegmentRequest request = request_for(cloud);
    *request.mutable_options() = wire::to_message(options);
    const Segmentation local = segment(cloud, options).value();
    ASSERT_LT(local.segmented_points, local.finite_points) << "something to leave out";
    expect_equal(ask(server, request, cloud.size()).segmentation, local);
  }
}

TEST(Segment, WithoutColorAndInAWorldView) {
  RunningServer server;
  Cloud cloud = wall_with_box();
  cloud.rgb.clear();
  cloud.view = View::world(0, 0, 0);
  expect_equal(ask(server, request_for(cloud), cloud.size()).segmentation, segment(cloud, {}).value());
}

TEST(Segment, EchoesWhatTheCallerSaid) {
  RunningServer server;
  v1::SegmentRequest request = request_for(wall_with_box());
  request.set_request_id("frame 7");
  request.set_frame_id("kinect");
  request.mutable_stamp()->set_seconds(1'700'000'000);
  request.mutable_stamp()->set_nanos(5);
  const auto response = server.segment(request);
  ASSERT_TRUE(response.ok()) << response.status();
  EXPECT_EQ(response->request_id(), "frame 7");
  EXPECT_EQ(response->frame_id(), "kinect");
  EXPECT_EQ(response->stamp().seconds(), 1'700'000'000);
  EXPECT_EQ(response->stamp().nanos(), 5);
}

TEST(Segment, SendsOnlyWhatWasAskedFor) {
  RunningServer server;
  const auto labels_only = server.segment(request_for(wall_with_box()));
  ASSERT_TRUE(labels_only.ok()) << labels_only.status();
  EXPECT_TRUE(labels_only->result().has_labels());
  EXPECT_EQ(labels_only->result().labels().data().compression(), v1::COMPRESSION_NONE);
  EXPECT_FALSE(labels_only->result().has_supervoxels());
  EXPECT_FALSE(labels_only->result().has_tree());
  EXPECT_EQ(labels_only->result().segments_size(), 0);
  EXPECT_EQ(labels_only->result().summary().timings().segments_ms(), 0);

  v1::SegmentRequest request = request_for(wall_with_box());
  request.mutable_outputs()->set_tree(true);
  const auto tree_only = server.segment(request);
  ASSERT_TRUE(tree_only.ok()) << tree_only.status();
  EXPECT_FALSE(tree_only->result().has_labels());
  EXPECT_TRUE(tree_only->result().has_tree());
}

TEST(Segment, TellsViewAndRuleAndTimings) {
  RunningServer server;
  const Cloud cloud = wall_with_box();
  const wire::Result result =
      ask(server, request_for_pcd(codec::encode_pcd(cloud, {}, codec::PcdEncoding::kBinaryCompressed)), cloud.size());
  EXPECT_EQ(result.view, View::camera());
  EXPECT_THAT(result.view_rule, testing::HasSubstr("CAMERA"));
  EXPECT_GT(result.timings.decode, 0);
  EXPECT_GT(result.timings.encode, 0);
  EXPECT_GT(result.segmentation.timings.total, 0);
  EXPECT_GE(result.timings.total, result.timings.decode + result.segmentation.timings.total + result.timings.encode);
}

TEST(Segment, ManyClientsAtOnceGetTheSameLabels) {
  ServerOptions options = small_server();
  options.workers = 3;
  RunningServer server(options);
  const v1::SegmentRequest request = request_for(wall_with_box());
  const std::string expected = server.segment(request)->result().labels().SerializeAsString();
  std::vector<std::future<std::string>> answers;
  for (int i = 0; i < 12; ++i) {
    answers.push_back(std::async(std::launch::async, [&server, &request] {
      return server.segment(request).value().result().labels().SerializeAsString();
    }));
  }
  for (auto& answer : answers) EXPECT_EQ(answer.get(), expected);
}

}  // namespace
}  // namespace segserve::server
