// SPDX-License-Identifier: Apache-2.0
#include "proto/wire/message_shape.hpp"

#include <cstdint>

#include "fmt/format.h"
#include "google/protobuf/descriptor.h"
#include "google/protobuf/io/coded_stream.h"
#include "google/protobuf/wire_format_lite.h"
#include "grpcpp/impl/codegen/proto_utils.h"
#include "grpcpp/support/proto_buffer_reader.h"
#include "proto/wire/status_message.hpp"

namespace segserve::wire {
namespace {

using google::protobuf::Descriptor;
using google::protobuf::FieldDescriptor;
using google::protobuf::internal::WireFormatLite;

constexpr int kMostLevels = 16;

/// Walks over the fields of a serialized message without building it.
class ShapeWalk {
 public:
  explicit ShapeWalk(google::protobuf::io::CodedInputStream& in) : in_(in) {}

  /// False if the bytes are no message, or `exceeded` has become true.
  bool message(const Descriptor& type, int level) {
    if (level > kMostLevels) return exceed();
    while (const std::uint32_t tag = in_.ReadTag()) {
      if (!count(1) || !field(type, tag, level)) return false;
    }
    return in_.ConsumedEntireMessage();
  }
  bool exceeded() const { return exceeded_; }

 private:
  bool field(const Descriptor& type, std::uint32_t tag, int level) {
    std::uint64_t ignored = 0;
    switch (WireFormatLite::GetTagWireType(tag)) {
      case WireFormatLite::WIRETYPE_VARINT:
        return in_.ReadVarint64(&ignored);
      case WireFormatLite::WIRETYPE_FIXED64:
        return in_.Skip(8);
      case WireFormatLite::WIRETYPE_FIXED32:
        return in_.Skip(4);
      case WireFormatLite::WIRETYPE_LENGTH_DELIMITED:
        return delimited(type.FindFieldByNumber(WireFormatLite::GetTagFieldNumber(tag)), level);
      default:
        return false;  // The API has no groups.
    }
  }

  /// `field` is null if it is unknown.
  bool delimited(const FieldDescriptor* field, int level) {
    int bytes = 0;
    if (!in_.ReadVarintSizeAsInt(&bytes)) return false;
    if (field != nullptr && field->cpp_type() == FieldDescriptor::CPPTYPE_MESSAGE) {
      const auto limit = in_.PushLimit(bytes);
      const bool good = message(*field->message_type(), level + 1);
      in_.PopLimit(limit);
      return good;
    }
    const bool packed = field != nullptr && field->is_repeated() && field->is_packable();
    if (packed && !count(static_cast<std::size_t>(bytes))) return false;
    return in_.Skip(bytes);
  }

  bool count(std::size_t values) {
    values_ += values;
    return values_ <= kMostMessageValues || exceed();
  }
  bool exceed() {
    exceeded_ = true;
    return false;
  }

  google::protobuf::io::CodedInputStream& in_;
  std::size_t values_ = 0;
  bool exceeded_ = false;
};

absl::Status check_shape(grpc::ByteBuffer& bytes, const char* name, const Descriptor& type) {
  grpc::ProtoBufferReader reader(&bytes);
  google::protobuf::io::CodedInputStream in(&reader);
  ShapeWalk walk(in);
  const bool good = walk.message(type, 1);
  if (walk.exceeded()) {
    return malformed(fmt::format("the {} has more than {} values, or more than {} messages in one another", name,
                                 kMostMessageValues, kMostLevels));
  }
  return good ? absl::OkStatus() : malformed(fmt::format("the message is no serialized {}", name));
}

}  // namespace

absl::Status parse_bounded(grpc::ByteBuffer& bytes, const char* name, google::protobuf::Message& message) {
  if (bytes.Valid()) {
    if (absl::Status status = check_shape(bytes, name, *message.GetDescriptor()); !status.ok()) {
      bytes.Clear();
      return status;
    }
  }
  if (!grpc::GenericDeserialize<grpc::ProtoBufferReader, google::protobuf::Message>(&bytes, &message).ok()) {
    return malformed(fmt::format("the message is no serialized {}", name));
  }
  message.DiscardUnknownFields();
  return absl::OkStatus();
}

}  // namespace segserve::wire
