// SPDX-License-Identifier: Apache-2.0
#include "proto/wire/message_shape.hpp"

#include <string>

#include "gmock/gmock.h"
#include "grpcpp/support/slice.h"
#include "gtest/gtest.h"
#include "proto/wire/status_message.hpp"
#include "segserve/v1/segmentation_service.pb.h"
#include "segserve/v1/stream.pb.h"

namespace segserve::wire {
namespace {

using testing::HasSubstr;

absl::Status parse(const std::string& bytes, google::protobuf::Message& message) {
  const grpc::Slice slice(bytes);
  grpc::ByteBuffer buffer(&slice, 1);
  return parse_bounded(buffer, "SegmentRequest", message);
}

v1::SegmentRequest honest_request() {
  v1::SegmentRequest request;
  request.set_request_id("seven");
  auto& strided = *request.mutable_cloud()->mutable_strided();
  for (int i = 0; i < 64; ++i) strided.add_fields()->set_name("field");
  request.mutable_outputs()->add_accepted_compressions(v1::COMPRESSION_ZSTD);
  return request;
}

TEST(ParseBounded, ReadsWhatWasWritten) {
  v1::SegmentRequest read;
  ASSERT_TRUE(parse(honest_request().SerializeAsString(), read).ok());
  EXPECT_EQ(read.SerializeAsString(), honest_request().SerializeAsString());
  EXPECT_TRUE(parse("", read).ok());
}

TEST(ParseBounded, DropsWhatItDoesNotKnow) {
  std::string bytes = honest_request().SerializeAsString();
  bytes += std::string("\xa0\x06\x01", 3);      // field 100 is the number 1
  bytes += std::string("\xaa\x06\x02hi", 5);    // field 101 is a text
  bytes += std::string("\xb5\x06\0\0\0\0", 6);  // field 102 has 4 bytes
  v1::SegmentRequest read;
  ASSERT_TRUE(parse(bytes, read).ok());
  EXPECT_EQ(read.SerializeAsString(), honest_request().SerializeAsString());
}

TEST(ParseBounded, RefusesGarbageAndTruncation) {
  v1::SegmentRequest read;
  const std::string good = honest_request().SerializeAsString();
  for (const std::string& bad :
       {std::string("\xff\xff\xff"), std::string("\x0b\x0c"), good.substr(0, good.size() - 1)}) {
    const absl::Status status = parse(bad, read);
    EXPECT_TRUE(absl::IsInvalidArgument(status)) << status;
    EXPECT_EQ(details_of(status).reason, ErrorReason::kMalformedPayload);
    EXPECT_THAT(std::string(status.message()), HasSubstr("no serialized SegmentRequest"));
  }
}

TEST(ParseBounded, RefusesMoreValuesThanAnyHonestMessageHas) {
  v1::SegmentRequest read;
  std::string unknown;
  for (int i = 0; i < 5000; ++i) unknown += std::string("\xa0\x06\x01", 3);
  v1::SegmentRequest many = honest_request();
  for (int i = 0; i < 5000; ++i) many.mutable_cloud()->mutable_strided()->add_fields();
  v1::SegmentRequest packed;
  for (int i = 0; i < 5000; ++i) packed.mutable_outputs()->add_accepted_compressions(v1::COMPRESSION_ZSTD);
  for (const std::string& bytes : {unknown, many.SerializeAsString(), packed.SerializeAsString()}) {
    const absl::Status status = parse(bytes, read);
    EXPECT_TRUE(absl::IsInvalidArgument(status)) << status;
    EXPECT_THAT(std::string(status.message()), HasSubstr("more than 4096 values"));
  }
}

}  // namespace
}  // namespace segserve::wire
