// SPDX-License-Identifier: Apache-2.0
#include "client/stream/outgoing_message.hpp"

#include <array>
#include <cstdint>
#include <utility>

#include "google/protobuf/io/coded_stream.h"
#include "grpcpp/support/slice.h"

namespace segserve::client {
namespace {

using google::protobuf::io::CodedOutputStream;

enum class WireType : std::uint32_t { kVarint = 0, kBytes = 2 };

constexpr std::uint32_t tag(int field, WireType type) {
  return static_cast<std::uint32_t>(field) << 3U | static_cast<std::uint32_t>(type);
}

std::size_t varint_size(std::uint64_t value) { return CodedOutputStream::VarintSize64(value); }

/// The bytes of a SegmentStreamRequest with a chunk that stand before the chunk's data.
struct ChunkPrefix {
  std::array<std::uint8_t, 64> bytes{};  // six numbers of at most 10 bytes each
  std::size_t size = 0;
};

ChunkPrefix chunk_prefix(std::uint64_t sequence, std::size_t data_bytes) {
  constexpr std::uint32_t kChunk = tag(v1::SegmentStreamRequest::kChunkFieldNumber, WireType::kBytes);
  constexpr std::uint32_t kSequence = tag(v1::FrameChunk::kSequenceFieldNumber, WireType::kVarint);
  constexpr std::uint32_t kData = tag(v1::FrameChunk::kDataFieldNumber, WireType::kBytes);
  const std::size_t chunk_bytes =
      varint_size(kSequence) + varint_size(sequence) + varint_size(kData) + varint_size(data_bytes) + data_bytes;
  ChunkPrefix prefix;
  std::uint8_t* end = prefix.bytes.data();
  for (const std::uint64_t number : {std::uint64_t{kChunk}, std::uint64_t{chunk_bytes}, std::uint64_t{kSequence},
                                     sequence, std::uint64_t{kData}, std::uint64_t{data_bytes}}) {
    end = CodedOutputStream::WriteVarint64ToArray(number, end);
  }
  prefix.size = static_cast<std::size_t>(end - prefix.bytes.data());
  return prefix;
}

grpc::Slice shared(std::string_view data, std::shared_ptr<const wire::ByteRun> owner) {
  using Owner = std::shared_ptr<const wire::ByteRun>;
  // gRPC takes a pointer that is not const, but only reads what it sends.
  void* const bytes = const_cast<char*>(data.data());
  return {bytes, data.size(), [](void* kept) { delete static_cast<Owner*>(kept); }, new Owner(std::move(owner))};
}

}  // namespace

std::size_t byte_size(const OutgoingMessage& outgoing) {
  if (outgoing.data.empty()) return outgoing.message.ByteSizeLong();
  return chunk_prefix(outgoing.message.chunk().sequence(), outgoing.data.size()).size + outgoing.data.size();
}

grpc::ByteBuffer serialize(const OutgoingMessage& outgoing) {
  if (outgoing.data.empty()) {
    const grpc::Slice bytes(outgoing.message.SerializeAsString());
    return {&bytes, 1};
  }
  const ChunkPrefix prefix = chunk_prefix(outgoing.message.chunk().sequence(), outgoing.data.size());
  const std::array slices{grpc::Slice(prefix.bytes.data(), prefix.size), shared(outgoing.data, outgoing.owner)};
  return {slices.data(), slices.size()};
}

}  // namespace segserve::client
