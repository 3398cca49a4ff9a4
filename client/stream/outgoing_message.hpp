// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <memory>
#include <string_view>

#include "grpcpp/support/byte_buffer.h"
#include "grpcpp/support/status.h"
#include "proto/wire/byte_run.hpp"
#include "segserve/v1/stream.pb.h"

namespace segserve::client {

/// A message of a stream on its way to the server. The bytes of a chunk are not copied into it: the socket reads them
/// from where they are.
struct OutgoingMessage {
  v1::SegmentStreamRequest message;
  /// The `data` of a message that is a chunk. They are not in `message`.
  std::string_view data;
  std::shared_ptr<const wire::ByteRun> owner;  ///< keeps `data`
};

/// The message with its data, byte for byte as protobuf would write it. The buffer shares the data.
grpc::ByteBuffer serialize(const OutgoingMessage& outgoing);

/// The size of what serialize() returns.
std::size_t byte_size(const OutgoingMessage& outgoing);

}  // namespace segserve::client

/// Tells gRPC how to serialize the message.
template <>
class grpc::SerializationTraits<segserve::client::OutgoingMessage> {
 public:
  // NOLINTNEXTLINE(readability-identifier-naming): gRPC looks for this name
  static grpc::Status Serialize(const segserve::client::OutgoingMessage& outgoing, grpc::ByteBuffer* bytes,
                                bool* own_buffer) {
    *bytes = segserve::client::serialize(outgoing);
    *own_buffer = true;
    return grpc::Status::OK;
  }
};
