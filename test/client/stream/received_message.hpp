// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "client/stream/outgoing_message.hpp"
#include "gtest/gtest.h"
#include "segserve/v1/stream.pb.h"

namespace segserve::client {

/// The bytes that gRPC gets, in one piece.
inline std::string wire_bytes(const OutgoingMessage& outgoing) {
  const grpc::ByteBuffer buffer = serialize(outgoing);
  std::vector<grpc::Slice> slices;
  EXPECT_TRUE(buffer.Dump(&slices).ok());
  std::string bytes;
  for (const grpc::Slice& slice : slices) bytes.append(reinterpret_cast<const char*>(slice.begin()), slice.size());
  return bytes;
}

/// The message that the server gets.
inline v1::SegmentStreamRequest received(const OutgoingMessage& outgoing) {
  v1::SegmentStreamRequest message;
  EXPECT_TRUE(message.ParseFromString(wire_bytes(outgoing)));
  return message;
}

}  // namespace segserve::client
