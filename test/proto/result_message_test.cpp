// SPDX-License-Identifier: Apache-2.0
#include "proto/wire/result_message.hpp"

#include <initializer_list>
#include <string>
#include <utility>
#include <vector>

#include "gmock/gmock.h"
#include "proto/wire/result_blocks.hpp"
#include "proto/wire/status_message.hpp"
#include "test/proto/example_messages.hpp"

namespace segserve::wire {
namespace {

constexpr Outputs kEverything{.labels = true, .supervoxels = true, .tree = true, .segments = true};

/// The result of six points, of which the last is not finite. It has two segments of three supervoxels (small_tree).
Result small_result() {
  Result result;
  result.segmentation.labels = {1, 1, 1, 1, 2, 0};
  result.segmentation.supervoxels = {1, 1, 2, 2, 3, 0};
  result.segmentation.tree = small_tree();
  result.segmentation.segments = 2;
  result.segmentation.statistics = small_statistics();
  result.segmentation.finite_points = 5;
  result.segmentation.segmented_points = 5;
  result.segmentation.voxels = 4;
  result.segmentation.threshold = 0.5;
  result.segmentation.lambda = 0.25;
  result.segmentation.timings = {
      .voxels = 1, .normals = 2, .supervoxels = 3, .graph = 4, .merging = 5, .labels = 6, .segments = 10};
  result.points = 6;
  result.supervoxels = 3;
  result.method = Method::kColor;
  result.view = View::world(1, 2, 3);
  result.view_rule = "because";
  result.timings = {.queue = 7, .decode = 8};
  result.server_version = "1.2.3";
  result.options_hash = "0123456789abcdef";
  return result;
}

std::string refusal(const v1::SegmentationResult& message, std::size_t points = 6) {
  const absl::Status status = from_message(message, points).status();
  EXPECT_EQ(details_of(status).reason, ErrorReason::kMalformedPayload) << status;
  return std::string(status.message());
}

std::string message_bytes(std::initializer_list<char> bytes) { return bytes; }

v1::SegmentationResult small_message() { return to_message(small_result(), kEverything).value(); }

TEST(WireResult, RoundTrips) {
  for (const auto compression : {Compression::kNone, Compression::kZstd}) {
    Outputs outputs = kEverything;
    outputs.compression = compression;
    v1::SegmentationResult message = to_message(small_result(), outputs).value();
    set_final_timings(message, 9, 45);
    const auto read = from_message(message, 6);
    ASSERT_TRUE(read.ok()) << read.status();
    const Result expected = small_result();
    EXPECT_EQ(read->segmentation.labels, expected.segmentation.labels);
    EXPECT_EQ(read->segmentation.supervoxels, expected.segmentation.supervoxels);
    EXPECT_EQ(read->segmentation.tree, expected.segmentation.tree);
    EXPECT_EQ(read->segmentation.segments, 2U);
    EXPECT_EQ(read->segmentation.finite_points, 5U);
    EXPECT_EQ(read->segmentation.segmented_points, 5U);
    EXPECT_EQ(read->segmentation.support_plane, std::nullopt);
    EXPECT_EQ(read->segmentation.voxels, 4U);
    EXPECT_EQ(read->segmentation.lambda, 0.25);
    EXPECT_EQ(read->segmentation.timings.merging, 5);
    EXPECT_EQ(read->segmentation.statistics, expected.segmentation.statistics);
    EXPECT_EQ(read->segmentation.timings.segments, 10);
    EXPECT_EQ(read->segmentation.timings.total, 31) << "the sum of the stages";
    EXPECT_EQ(read->supervoxels, 3U);
    EXPECT_EQ(read->method, Method::kColor);
    EXPECT_EQ(read->segmentation.threshold, 0.5);
    EXPECT_EQ(read->regions, std::nullopt);
    EXPECT_EQ(read->view, expected.view);
    EXPECT_EQ(read->view_rule, "because");
    EXPECT_EQ(read->timings.queue, 7);
    EXPECT_EQ(read->timings.total, 45);
    EXPECT_EQ(read->server_version, "1.2.3");
    EXPECT_EQ(read->options_hash, "0123456789abcdef");
  }
}

TEST(WireResult, TellsTheSupportPlane) {
  Result result = small_result();
  for (const SupportPlane& plane :
       {SupportPlane{.normal = {0, 0.6, -0.8}, .offset = -0.5, .points = 1}, SupportPlane{}}) {
    result.segmentation.finite_points = 6;
    result.segmentation.support_plane = plane;
    const auto read = from_message(to_message(result, kEverything).value(), 6);
    ASSERT_TRUE(read.ok()) << read.status();
    EXPECT_EQ(read->segmentation.support_plane, plane);
  }
}

TEST(WireResult, IsInTheCoordinatesOfThePayload) {
  Result result = small_result();
  const Eigen::Vector3d centroid = result.segmentation.statistics[0].centroid;
  const codec::Placement placement{{0.001, -0.001, -0.001}, {1000, 2000, 0}};
  take_payload_facts(placement, {{codec::WarningReason::kColorNotUsed, "first"}}, result);
  const auto read = from_message(to_message(result, kEverything).value(), 6);
  ASSERT_TRUE(read.ok()) << read.status();
  EXPECT_EQ(read->placement, placement);
  EXPECT_TRUE(read->segmentation.statistics[0].centroid.isApprox(placement.to_file(centroid)));
  EXPECT_EQ(read->warnings.at(0).message, "first");
}

TEST(WireResult, APlacementThatIsNoneIsRefused) {
  v1::SegmentationResult message = small_message();
  message.mutable_summary()->mutable_placement()->mutable_scale()->set_x(1);
  EXPECT_THAT(refusal(message), testing::HasSubstr("placement"));
}

TEST(WireResult, TellsWhatIsProbablyWrong) {
  const auto reasons = [](const Segmentation& segmentation) {
    std::vector<codec::WarningReason> all;
    Cloud cloud;
    for (const codec::Warning& warning : make_result(segmentation, cloud, {}, "", "").warnings) {
      all.push_back(warning.reason);
    }
    return all;
  };
  using codec::WarningReason;
  Segmentation good;
  good.segmented_points = 5000;
  good.voxels = 1000;
  EXPECT_THAT(reasons(good), testing::IsEmpty());
  Segmentation odd = good;
  odd.zero_points = 1;
  odd.points_beyond_grid = 2;
  odd.fitting_resolution = 0.5;
  EXPECT_THAT(reasons(odd), testing::ElementsAre(WarningReason::kPointsNotUsed, WarningReason::kPointsNotUsed,
                                                 WarningReason::kTooSparse));
  odd.unfit_preset = "the preset has no effect";
  EXPECT_THAT(reasons(odd), testing::Contains(WarningReason::kPresetNotFit));
  good.voxels = 3;
  EXPECT_THAT(reasons(good), testing::ElementsAre(WarningReason::kTooDense));
  good.segmented_points = 64;
  EXPECT_THAT(reasons(good), testing::ElementsAre(WarningReason::kTooDense));
  good.segmented_points = 63;
  EXPECT_THAT(reasons(good), testing::IsEmpty());
  EXPECT_THAT(reasons(Segmentation()), testing::ElementsAre(WarningReason::kNoPoints));
}

TEST(WireResult, TellsThatDepthsOfACameraAreInAnotherUnit) {
  Segmentation segmentation;
  segmentation.segmented_points = 5000;
  segmentation.voxels = 1000;
  const auto warnings = [&](double depth, const View& view) {
    segmentation.supervoxel_features.clear();
    for (const double z : {0.5 * depth, depth, 2 * depth}) {
      segmentation.supervoxel_features.push_back({.centroid = {0, 0, z}});
    }
    Cloud cloud;
    cloud.view = view;
    return make_result(segmentation, cloud, {}, "", "").warnings;
  };
  for (const double meters : {0.1, 1.0, 60.0}) EXPECT_THAT(warnings(meters, View::camera()), testing::IsEmpty());
  const auto far = warnings(900, View::camera()), near = warnings(0.001, View::camera());
  ASSERT_EQ(far.size(), 1U);
  EXPECT_EQ(far[0].reason, codec::WarningReason::kTooSparse);
  EXPECT_THAT(far[0].message, testing::HasSubstr("farther than 900 m from the camera: the unit"));
  ASSERT_EQ(near.size(), 1U);
  EXPECT_EQ(near[0].reason, codec::WarningReason::kTooDense);
  EXPECT_THAT(warnings(900, View::world()), testing::IsEmpty());
}

TEST(WireResult, HoldsOnlyWhatWasAskedFor) {
  const auto message = to_message(small_result(), {.labels = false, .supervoxels = false, .tree = true});
  EXPECT_FALSE(message->has_labels());
  EXPECT_FALSE(message->has_supervoxels());
  EXPECT_EQ(message->segments_size(), 0);
  const auto read = from_message(*message, 6);
  ASSERT_TRUE(read.ok()) << read.status();
  EXPECT_TRUE(read->segmentation.labels.empty());
  EXPECT_EQ(read->segmentation.tree, small_tree());
}

TEST(WireResult, ItsBytesTravelApartFromItInTheDocumentedOrder) {
  v1::SegmentationResult message = small_message();
  const std::vector<std::uint64_t> sizes = result_block_sizes(message);
  EXPECT_THAT(sizes, testing::ElementsAre(6, 6, 3, 2, 2, 16));
  std::vector<std::string> bytes;
  for (std::string* block : result_blocks(message)) bytes.push_back(std::exchange(*block, {}));
  EXPECT_EQ(bytes[0], message_bytes({1, 1, 1, 1, 2, 0}));
  EXPECT_EQ(bytes[1], message_bytes({1, 1, 2, 2, 3, 0}));
  EXPECT_EQ(bytes[2], message_bytes({2, 2, 1}));
  EXPECT_EQ(bytes[3], message_bytes({0, 2}));
  EXPECT_EQ(bytes[4], message_bytes({1, 3}));
  EXPECT_LT(message.tree().ByteSizeLong(), 64U) << "nothing but sizes is left";
  EXPECT_THAT(refusal(message), testing::HasSubstr("encoded bytes"));
  for (std::size_t i = 0; i < bytes.size(); ++i) *result_blocks(message)[i] = bytes[i];
  EXPECT_EQ(from_message(message, 6)->segmentation.tree, small_tree());
}

TEST(WireResult, ATreeWithoutColumnsIsRefused) {
  v1::SegmentationResult message = small_message();
  message.mutable_tree()->Clear();
  EXPECT_THAT(result_block_sizes(message), testing::ElementsAre(6, 6, 0, 0, 0, 0));
  EXPECT_EQ(result_blocks(message).size(), 6U);
  EXPECT_THAT(refusal(message), testing::HasSubstr("tree.leaf_points"));
}

TEST(WireResult, MustBeOfTheCloudThatWasSent) {
  EXPECT_THAT(refusal(small_message(), 7), testing::HasSubstr("the result has 6 points, but the cloud has 7"));
}

TEST(WireResult, MustAgreeWithItself) {
  const auto refusal_of = [](const auto& damage) {
    v1::SegmentationResult message = small_message();
    damage(message, *message.mutable_summary());
    return refusal(message);
  };
  using testing::HasSubstr;
  constexpr const char* kContradiction = "the numbers of the summary contradict each other";
  EXPECT_THAT(refusal_of([](auto&, auto& summary) { summary.set_segments(1); }), HasSubstr("labels: holds 2"));
  EXPECT_THAT(refusal_of([](auto&, auto& summary) { summary.set_supervoxels(4); }),
              HasSubstr("tree.leaf_points: has 3 values, but must have 4"));
  EXPECT_THAT(refusal_of([](auto&, auto& summary) { summary.set_segmented_points(4); }),
              HasSubstr("have 5 points, but by the summary 2 segments have 4 points"));
  EXPECT_THAT(refusal_of([](auto&, auto& summary) { summary.set_finite_points(7); }), HasSubstr(kContradiction));
  EXPECT_THAT(refusal_of([](auto&, auto& summary) { summary.set_segmented_points(6); }), HasSubstr(kContradiction));
  EXPECT_THAT(refusal_of([](auto&, auto& summary) { summary.mutable_support_plane()->set_points(1); }),
              HasSubstr(kContradiction))
      << "all five finite points are segmented";
  EXPECT_THAT(refusal_of([](auto& message, auto&) { message.mutable_segments(0)->set_points(3); }),
              HasSubstr("have 4 points, but by the summary 2 segments have 5 points"));
  EXPECT_THAT(refusal_of([](auto&, auto& summary) { summary.clear_view(); }), HasSubstr("which view was used"));
  EXPECT_THAT(refusal_of([](auto&, auto& summary) { summary.clear_method(); }), HasSubstr("which method was used"));
  EXPECT_THAT(refusal({}), HasSubstr("the result has 0 points, but the cloud has 6"));
}

}  // namespace
}  // namespace segserve::wire
