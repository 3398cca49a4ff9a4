// SPDX-License-Identifier: Apache-2.0
#include "client/stream/outgoing_message.hpp"

#include <cstdint>
#include <memory>
#include <string>
#include <utility>

#include "test/client/stream/received_message.hpp"

namespace segserve::client {
namespace {

OutgoingMessage chunk(std::uint64_t sequence, std::shared_ptr<std::string> bytes) {
  OutgoingMessage outgoing;
  outgoing.message.mutable_chunk()->set_sequence(sequence);
  outgoing.data = *bytes;
  outgoing.owner = std::make_shared<const wire::ByteRun>(std::vector<std::string_view>{*bytes}, bytes);
  return outgoing;
}

TEST(OutgoingMessage, AChunkIsWrittenAsProtobufWritesIt) {
  for (const std::uint64_t sequence : {std::uint64_t{1}, std::uint64_t{127}, std::uint64_t{128}, ~std::uint64_t{0}}) {
    for (const std::size_t size : {std::size_t{1}, std::size_t{127}, std::size_t{128}, std::size_t{256} << 10U}) {
      const auto bytes = std::make_shared<std::string>(size, 'x');
      bytes->back() = 'y';
      const OutgoingMessage outgoing = chunk(sequence, bytes);
      v1::SegmentStreamRequest expected;
      expected.mutable_chunk()->set_sequence(sequence);
      expected.mutable_chunk()->set_data(*bytes);
      EXPECT_EQ(wire_bytes(outgoing), expected.SerializeAsString()) << sequence << ", " << size;
      EXPECT_EQ(byte_size(outgoing), expected.ByteSizeLong());
    }
  }
}

TEST(OutgoingMessage, OtherMessagesAreWrittenAsTheyAre) {
  OutgoingMessage outgoing;
  outgoing.message.mutable_frame()->set_frame_id("camera");
  EXPECT_EQ(wire_bytes(outgoing), outgoing.message.SerializeAsString());
  EXPECT_EQ(byte_size(outgoing), outgoing.message.ByteSizeLong());
}

TEST(OutgoingMessage, SharesTheDataUntilTheyAreSent) {
  auto bytes = std::make_shared<std::string>(1000, 'x');
  OutgoingMessage outgoing = chunk(1, bytes);
  grpc::ByteBuffer buffer = serialize(outgoing);
  outgoing = {};
  EXPECT_EQ(bytes.use_count(), 2) << "only the buffer shares the data";
  {
    std::vector<grpc::Slice> slices;
    ASSERT_TRUE(buffer.Dump(&slices).ok());
    EXPECT_EQ(static_cast<const void*>(slices.back().begin()), static_cast<const void*>(bytes->data()));
  }
  buffer.Clear();
  EXPECT_EQ(bytes.use_count(), 1);
}

}  // namespace
}  // namespace segserve::client
