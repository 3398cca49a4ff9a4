// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <bit>
#include <cstdint>
#include <optional>
#include <string_view>

namespace segserve::recording {

/// A field of a protobuf message.
struct ProtoField {
  std::uint32_t number = 0;
  std::uint64_t value = 0;  ///< of varints and fixed numbers
  std::string_view bytes;   ///< of strings, bytes and messages
  std::string_view whole;   ///< the field as it stands in the message

  double as_double() const { return std::bit_cast<double>(value); }
};

/// Takes the fields of an untrusted protobuf message one by one
/// (https://protobuf.dev/programming-guides/encoding). Groups, which proto3 does not have, are damage.
class ProtoReader {
 public:
  explicit ProtoReader(std::string_view message) : rest_(message) {}

  /// The next field; nothing at the end, or if the rest is damaged.
  std::optional<ProtoField> next();
  /// False once a field was damaged.
  bool ok() const { return ok_; }

 private:
  std::optional<std::uint64_t> varint();
  std::optional<std::uint64_t> fixed(std::size_t bytes);
  bool read_value(std::uint32_t wire_type, ProtoField& field);

  std::string_view rest_;
  bool ok_ = true;
};

}  // namespace segserve::recording
