// SPDX-License-Identifier: Apache-2.0
#include "proto/wire/request_message.hpp"

#include <string>
#include <vector>

#include "gmock/gmock.h"
#include "proto/wire/cloud_message.hpp"
#include "proto/wire/payload_blocks.hpp"
#include "proto/wire/status_message.hpp"
#include "test/proto/example_messages.hpp"

namespace segserve::wire {
namespace {

v1::SegmentRequest good_request() {
  v1::SegmentRequest request;
  *request.mutable_cloud() = to_planar_message(small_cloud(), v1::COMPRESSION_NONE).value();
  return request;
}

std::vector<std::string> wrong_fields(const absl::Status& status) {
  std::vector<std::string> fields;
  for (const FieldViolation& fault : details_of(status).fields) fields.push_back(fault.field);
  return fields;
}

TEST(WireRequest, WithoutOutputsMeansPlainLabels) {
  const auto parsed = parse_request(good_request(), {});
  ASSERT_TRUE(parsed.ok()) << parsed.status();
  EXPECT_EQ(parsed->outputs, Outputs{});
}

TEST(WireRequest, OutputsRoundTrip) {
  const Outputs outputs{
      .labels = false, .supervoxels = true, .tree = true, .segments = true, .compression = Compression::kZstd};
  v1::SegmentRequest request = good_request();
  *request.mutable_outputs() = to_message(outputs);
  EXPECT_EQ(parse_request(request, {})->outputs, outputs);
}

TEST(WireRequest, CompressionsOfTheFutureAreNotChosen) {
  v1::SegmentRequest request = good_request();
  request.mutable_outputs()->add_accepted_compressions(static_cast<v1::Compression>(99));
  EXPECT_EQ(parse_request(request, {})->outputs.compression, Compression::kNone);
}

TEST(WireRequest, NamesEveryWrongFieldOfEveryPart) {
  v1::SegmentRequest request = good_request();
  request.set_request_id(std::string(257, 'x'));
  request.mutable_cloud()->set_width(0);
  request.mutable_options()->set_threshold(2);
  const absl::Status status = parse_request(request, {}).status();
  EXPECT_EQ(status.code(), absl::StatusCode::kInvalidArgument);
  EXPECT_EQ(details_of(status).reason, ErrorReason::kInvalidField);
  EXPECT_THAT(wrong_fields(status), testing::UnorderedElementsAre("request_id", "cloud.width", "options.threshold"));
}

TEST(WireRequest, AFrameHeaderAnnouncesItsBytesAndHoldsNone) {
  v1::FrameHeader header;
  *header.mutable_cloud() = to_planar_message(small_cloud(), v1::COMPRESSION_NONE).value();
  header.set_encoded_bytes(90);
  EXPECT_THAT(wrong_fields(parse_frame(header, {}, {}).status()), testing::ElementsAre("cloud"));
  for (std::string* data : payload_blocks(*header.mutable_cloud())) data->clear();
  EXPECT_TRUE(parse_frame(header, {}, {}).ok());
  header.set_encoded_bytes(91);
  EXPECT_THAT(wrong_fields(parse_frame(header, {}, {}).status()), testing::ElementsAre("encoded_bytes"));
}

TEST(WireRequest, NeedsACloud) { EXPECT_EQ(details_of(parse_request({}, {}).status()).fields.at(0).field, "cloud"); }

}  // namespace
}  // namespace segserve::wire
