// SPDX-License-Identifier: Apache-2.0
#include <atomic>
#include <cmath>
#include <limits>
#include <new>
#include <stdexcept>
#include <string>
#include <vector>

#include "gmock/gmock.h"
#include "grpcpp/generic/generic_stub.h"
#include "proto/wire/result_message.hpp"
#include "proto/wire/status_message.hpp"
#include "segserve/codec/pcd.hpp"
#include "test/server/support/fake_backend.hpp"
#include "test/server/support/running_server.hpp"
#include "test/server/support/server_scenes.hpp"

namespace segserve::server {
namespace {

using testing::Contains;
using testing::HasSubstr;

constexpr float kNaN = std::numeric_limits<float>::quiet_NaN();

/// After every case, the server must still answer a good request.
class BadInput : public testing::Test {
 protected:
  ~BadInput() override { EXPECT_TRUE(server_.segment(request_for(wall_with_box(40, 30))).ok()); }

  wire::ErrorDetails refuse(const v1::SegmentRequest& request, wire::ErrorReason reason) {
    const absl::Status status = server_.segment(request).status();
    EXPECT_EQ(status.code(), absl::StatusCode::kInvalidArgument) << status;
    EXPECT_FALSE(status.message().empty());
    message_ = std::string(status.message());
    const wire::ErrorDetails details = wire::details_of(status);
    EXPECT_EQ(wire::name(details.reason), wire::name(reason)) << status;
    return details;
  }

  std::vector<std::string> wrong_fields(const v1::SegmentRequest& request) {
    std::vector<std::string> fields;
    for (const FieldViolation& fault : refuse(request, wire::ErrorReason::kInvalidField).fields) {
      fields.push_back(fault.field);
    }
    return fields;
  }

  wire::Result accept(const Cloud& cloud) {
    const auto response = server_.segment(request_for(cloud));
    EXPECT_TRUE(response.ok()) << response.status();
    return wire::from_message(response.value().result(), cloud.size()).value();
  }

  RunningServer server_;
  std::string message_;
};

TEST_F(BadInput, EmptyRequest) { EXPECT_THAT(wrong_fields({}), testing::ElementsAre("cloud")); }

TEST_F(BadInput, EmptyPlanarCloud) {
  v1::SegmentRequest request = request_for(wall_with_box());
  request.mutable_cloud()->set_width(0);
  EXPECT_THAT(wrong_fields(request), testing::ElementsAre("cloud.width"));
}

TEST_F(BadInput, EmptyPcdFile) {
  const std::string header =
      "VERSION .7\nFIELDS x y z\nSIZE 4 4 4\nTYPE F F F\nCOUNT 1 1 1\nWIDTH 0\nHEIGHT 1\nPOINTS 0\nDATA binary\n";
  refuse(request_for_pcd(header), wire::ErrorReason::kInvalidCloud);
  EXPECT_THAT(message_, HasSubstr("empty"));
}

TEST_F(BadInput, TruncatedPcdFile) {
  std::string file = codec::encode_pcd(wall_with_box(), {}, codec::PcdEncoding::kBinaryCompressed);
  file.resize(file.size() / 2);
  refuse(request_for_pcd(file), wire::ErrorReason::kMalformedPayload);
}

TEST_F(BadInput, PcdHeaderThatLies) {
  std::string file = codec::encode_pcd(equal_points(10, 0, 0, 1), {}, codec::PcdEncoding::kBinary);
  for (std::size_t at = file.find("10\n"); at < file.find("DATA"); at = file.find("10\n", at + 1)) {
    file.replace(at, 2, "1999999");
  }
  refuse(request_for_pcd(file), wire::ErrorReason::kMalformedPayload);
}

TEST_F(BadInput, GarbageAsPcd) {
  refuse(request_for_pcd("\x7f"
                         "ELF, not a cloud"),
         wire::ErrorReason::kMalformedPayload);
}

TEST_F(BadInput, PlaneOfTheWrongLength) {
  v1::SegmentRequest request = request_for(wall_with_box());
  request.mutable_cloud()->mutable_planar()->mutable_z()->mutable_data()->resize(17);
  refuse(request, wire::ErrorReason::kMalformedPayload);
  EXPECT_THAT(message_, HasSubstr("cloud.planar.z"));
}

TEST_F(BadInput, BrokenZstd) {
  v1::SegmentRequest request = request_for(wall_with_box(), v1::COMPRESSION_ZSTD);
  std::string& bytes = *request.mutable_cloud()->mutable_planar()->mutable_x()->mutable_data();
  bytes.resize(bytes.size() - 3);
  refuse(request, wire::ErrorReason::kMalformedPayload);
  EXPECT_THAT(message_, HasSubstr("cloud.planar.x"));
}

TEST_F(BadInput, EveryWrongOptionIsNamed) {
  v1::SegmentRequest request = request_for(wall_with_box());
  request.mutable_options()->set_threshold(-1);
  request.mutable_options()->set_voxel_resolution(std::nan(""));
  request.mutable_options()->set_seed_resolution(1e9);
  EXPECT_THAT(wrong_fields(request),
              testing::IsSupersetOf({"options.threshold", "options.voxel_resolution", "options.seed_resolution"}));
}

TEST_F(BadInput, ThresholdThatIsNoNumber) {
  v1::SegmentRequest request = request_for(wall_with_box());
  request.mutable_options()->set_threshold(std::nan(""));
  EXPECT_THAT(wrong_fields(request), testing::ElementsAre("options.threshold"));
  EXPECT_THAT(message_, HasSubstr("nan"));
}

TEST_F(BadInput, CropBoxInsideOut) {
  v1::SegmentRequest request = request_for(wall_with_box());
  request.mutable_options()->set_crop_min_y(1);
  request.mutable_options()->set_crop_max_y(0);
  request.mutable_options()->set_crop_max_z(std::nan(""));
  EXPECT_THAT(wrong_fields(request), testing::UnorderedElementsAre("options.crop_max_y", "options.crop_max_z"));
}

TEST_F(BadInput, RangeWithoutASensor) {
  Cloud cloud = wall_with_box();
  cloud.view = View::world();
  v1::SegmentRequest request = request_for(cloud);
  request.mutable_options()->set_range_min(0.5);
  request.mutable_options()->set_range_max(2);
  EXPECT_THAT(wrong_fields(request), testing::ElementsAre("options.range_min", "options.range_max"));
  EXPECT_THAT(message_, HasSubstr("sensor"));
}

TEST_F(BadInput, SupportPlaneOfNoThickness) {
  v1::SegmentRequest request = request_for(wall_with_box());
  request.mutable_options()->set_support_plane_distance(0);
  EXPECT_THAT(wrong_fields(request), testing::ElementsAre("options.support_plane_distance"));
}

TEST_F(BadInput, NoRegions) {
  v1::SegmentRequest request = request_for(wall_with_box());
  request.mutable_options()->set_regions(0);
  EXPECT_THAT(wrong_fields(request), testing::ElementsAre("options.regions"));
}

TEST_F(BadInput, CoordinatesBeyondTheGrid) {
  refuse(request_for(equal_points(5, 1e30F, 0, 0, View::world())), wire::ErrorReason::kInvalidCloud);
}

TEST_F(BadInput, CameraPointBehindTheCamera) {
  for (const float z : {0.0F, -1.0F}) {
    refuse(request_for(equal_points(5, 0.5F, 0, z)), wire::ErrorReason::kInvalidCloud);
    EXPECT_THAT(message_, HasSubstr("z"));
  }
}

TEST_F(BadInput, PlanarWithoutAView) {
  v1::SegmentRequest request = request_for(wall_with_box());
  request.mutable_cloud()->clear_view();
  EXPECT_THAT(wrong_fields(request), testing::ElementsAre("cloud.view"));
}

TEST_F(BadInput, IdsThatAreTooLong) {
  v1::SegmentRequest request = request_for(wall_with_box());
  request.set_request_id(std::string(257, 'a'));
  request.set_frame_id(std::string(257, 'a'));
  EXPECT_THAT(wrong_fields(request), testing::UnorderedElementsAre("request_id", "frame_id"));
}

TEST_F(BadInput, BytesThatAreNoMessage) {
  grpc::GenericStub stub(server_.channel());
  grpc::CompletionQueue queue;
  grpc::ClientContext context;
  const grpc::Slice bytes("\xff\xff\xff\xff not protobuf");
  const auto call =
      stub.PrepareUnaryCall(&context, "/segserve.v1.SegmentationService/Segment", grpc::ByteBuffer(&bytes, 1), &queue);
  call->StartCall();
  grpc::ByteBuffer response;
  grpc::Status status;
  call->Finish(&response, &status, nullptr);
  void* tag = nullptr;
  bool ok = false;
  ASSERT_TRUE(queue.Next(&tag, &ok));
  EXPECT_EQ(status.error_code(), grpc::StatusCode::INVALID_ARGUMENT);
  EXPECT_EQ(wire::details_of(wire::from_grpc(status)).reason, wire::ErrorReason::kMalformedPayload);
}

// Odd requests that are valid have a defined result.

TEST_F(BadInput, AllPointsNotFiniteGiveLabelZero) {
  const wire::Result result = accept(equal_points(5, kNaN, kNaN, kNaN));
  EXPECT_THAT(result.segmentation.labels, testing::ElementsAre(0, 0, 0, 0, 0));
  EXPECT_EQ(result.segmentation.segments, 0U);
}

TEST_F(BadInput, OnePointIsOneSegment) {
  EXPECT_THAT(accept(equal_points(1, 0.1F, 0.2F, 1)).segmentation.labels, testing::ElementsAre(1));
}

TEST_F(BadInput, EqualPointsAreOneSegment) {
  const wire::Result result = accept(equal_points(1000, 0.1F, 0.2F, 1));
  EXPECT_EQ(result.segmentation.segments, 1U);
  EXPECT_THAT(result.segmentation.labels, testing::Each(1U));
}

TEST_F(BadInput, NotANumberAsColorIsBlack) {
  const std::string file =
      "VERSION .7\nFIELDS x y z rgb\nSIZE 4 4 4 4\nTYPE F F F F\nCOUNT 1 1 1 1\nWIDTH 2\nHEIGHT 1\nPOINTS 2\n"
      "DATA ascii\n0 0 1 nan\n0.001 0 1 nan\n";
  EXPECT_TRUE(server_.segment(request_for_pcd(file)).ok());
}

/// Throws in the first calls, one kind of exception after the other, and then segments.
BackendFactory throwing_factory(std::atomic<int>& calls) {
  return fake_factory(
      [&calls](const CloudView& cloud, const Options& options, const StopToken& stop) -> absl::StatusOr<Segmentation> {
        switch (calls++) {
          case 0:
            throw std::runtime_error("secret");
          case 1:
            throw std::bad_alloc();
          case 2:
            throw 1;
          default:
            return segment(cloud, options, stop);
        }
      });
}

TEST(Faults, AnExceptionOfTheBackendIsInternalAndLeaksNothing) {
  std::atomic<int> calls = 0;
  RunningServer server(small_server(), throwing_factory(calls));
  for (int i = 0; i < 3; ++i) {
    const absl::Status status = server.segment(request_for(wall_with_box(8, 8))).status();
    EXPECT_EQ(status.code(), absl::StatusCode::kInternal);
    EXPECT_EQ(wire::details_of(status).reason, wire::ErrorReason::kInternal);
    EXPECT_THAT(std::string(status.message()), testing::Not(HasSubstr("secret")));
  }
  EXPECT_TRUE(server.segment(request_for(wall_with_box(8, 8))).ok()) << "the worker goes on";
}

}  // namespace
}  // namespace segserve::server
