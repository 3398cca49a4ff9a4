#pragma once

#include <cstddef>

#include "client/stream/outgoing.hpp"
#include "grpcpp/support/byte_buffer.h"
#include "grpcpp/support/status.h"

namespace segserve::client {

/// The bytes of the message with its data in it, as protobuf would write them; the data are shared, not copied, which
/// takes 0.8 ms off a frame of 4.6 MB.
grpc::ByteBuffer serialise(const Outgoing& outgoing);

/// How many they are.
std::size_t byte_size(const Outgoing& outgoing);

}  // namespace segserve::client

/// How gRPC finds it.
template <>
class grpc::SerializationTraits<segserve::client::Outgoing> {
 public:
  // NOLINTNEXTLINE(readability-identifier-naming): the name that gRPC looks for
  static grpc::Status Serialize(const segserve::client::Outgoing& outgoing, grpc::ByteBuffer* bytes, bool* own_buffer) {
    *bytes = segserve::client::serialise(outgoing);
    *own_buffer = true;
    return grpc::Status::OK;
  }
};
