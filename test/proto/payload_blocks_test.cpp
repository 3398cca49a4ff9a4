// SPDX-License-Identifier: Apache-2.0
#include "proto/wire/payload_blocks.hpp"

#include <limits>
#include <string>
#include <vector>

#include "gmock/gmock.h"
#include "proto/wire/cloud_message.hpp"
#include "test/proto/example_messages.hpp"

namespace segserve::wire {
namespace {

using testing::ElementsAre;
using testing::IsEmpty;

TEST(PayloadBlocks, PlanesComeInTheirOrderAndTellTheirSizes) {
  v1::Cloud message = to_planar_message(small_cloud(), v1::COMPRESSION_NONE).value();
  EXPECT_THAT(payload_blocks(message), ElementsAre(&message.planar().x().data(), &message.planar().y().data(),
                                                   &message.planar().z().data(), &message.planar().rgb().data()));
  EXPECT_THAT(payload_block_sizes(message), ElementsAre(24, 24, 24, 18));
  EXPECT_EQ(payload_bytes(message), 90U);
}

TEST(PayloadBlocks, AbsentBlocksAreSkipped) {
  Cloud cloud = small_cloud();
  cloud.rgb.clear();
  v1::Cloud message = to_planar_message(cloud, v1::COMPRESSION_ZSTD).value();
  EXPECT_EQ(payload_blocks(message).size(), 3U);
  v1::Cloud nothing;
  EXPECT_THAT(payload_blocks(nothing), IsEmpty());
  EXPECT_EQ(payload_bytes(nothing), 0U);
}

/// Takes the bytes out of the message as a stream does, and puts them back.
TEST(PayloadBlocks, BytesCanFollowTheirHeader) {
  for (const auto compression : {v1::COMPRESSION_NONE, v1::COMPRESSION_ZSTD}) {
    const v1::Cloud whole = to_planar_message(small_cloud(), compression).value();
    v1::Cloud header = whole;
    std::string run;
    for (std::string* data : payload_blocks(header)) {
      run += *data;
      data->clear();
    }
    ASSERT_EQ(run.size(), payload_bytes(header));
    EXPECT_TRUE(payload_has_data(whole));
    EXPECT_FALSE(payload_has_data(header));
    std::size_t at = 0;
    const std::vector<std::uint64_t> sizes = payload_block_sizes(header);
    const std::vector<std::string*> data = payload_blocks(header);
    for (std::size_t i = 0; i < data.size(); at += sizes[i], ++i) *data[i] = run.substr(at, sizes[i]);
    EXPECT_EQ(header.SerializeAsString(), whole.SerializeAsString());
  }
}

TEST(PayloadBlocks, SizesThatOverflowAreNotTakenForSmallOnes) {
  v1::Cloud message = to_planar_message(small_cloud(), v1::COMPRESSION_NONE).value();
  message.mutable_planar()->mutable_x()->set_encoded_bytes(std::numeric_limits<std::uint64_t>::max() - 10);
  EXPECT_EQ(payload_bytes(message), std::numeric_limits<std::uint64_t>::max());
}

TEST(PayloadBlocks, OfEveryPayloadComeInTheOrderOfTheirFields) {
  v1::Cloud message;
  message.mutable_rgbd()->mutable_color()->set_encoded_bytes(2);
  message.mutable_rgbd()->mutable_depth()->set_encoded_bytes(1);
  EXPECT_THAT(payload_block_sizes(message), ElementsAre(1, 2));
  message.mutable_draco()->mutable_finite()->set_encoded_bytes(4);
  message.mutable_draco()->mutable_data()->set_encoded_bytes(3);
  EXPECT_THAT(payload_block_sizes(message), ElementsAre(3, 4));
  message.mutable_strided()->mutable_data()->set_encoded_bytes(5);
  EXPECT_THAT(payload_block_sizes(message), ElementsAre(5));
  message.mutable_quantised()->mutable_data()->set_encoded_bytes(6);
  EXPECT_THAT(payload_block_sizes(message), ElementsAre(6));
  message.mutable_pcd_file()->mutable_file()->set_encoded_bytes(7);
  EXPECT_THAT(payload_block_sizes(message), ElementsAre(7));
}

}  // namespace
}  // namespace segserve::wire
