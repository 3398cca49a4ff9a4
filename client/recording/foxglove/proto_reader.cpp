// SPDX-License-Identifier: Apache-2.0
#include "client/recording/foxglove/proto_reader.hpp"

#include <cstring>

namespace segserve::recording {
namespace {

enum WireType : std::uint32_t { kVarint = 0, kFixed64 = 1, kLength = 2, kFixed32 = 5 };

}  // namespace

std::optional<std::uint64_t> ProtoReader::varint() {
  constexpr std::size_t kMostBytes = 10;
  std::uint64_t value = 0;
  for (std::size_t i = 0; i < kMostBytes && i < rest_.size(); ++i) {
    const auto byte = static_cast<std::uint8_t>(rest_[i]);
    value |= std::uint64_t{byte & 0x7FU} << (7 * i);
    if ((byte & 0x80U) == 0) {
      rest_.remove_prefix(i + 1);
      return value;
    }
  }
  return std::nullopt;
}

std::optional<std::uint64_t> ProtoReader::fixed(std::size_t bytes) {
  if (rest_.size() < bytes) return std::nullopt;
  std::uint64_t value = 0;
  std::memcpy(&value, rest_.data(), bytes);
  rest_.remove_prefix(bytes);
  return value;
}

bool ProtoReader::read_value(std::uint32_t wire_type, ProtoField& field) {
  std::optional<std::uint64_t> value;
  if (wire_type == kVarint || wire_type == kLength) value = varint();
  if (wire_type == kFixed64) value = fixed(sizeof(std::uint64_t));
  if (wire_type == kFixed32) value = fixed(sizeof(std::uint32_t));
  if (!value) return false;
  if (wire_type != kLength) {
    field.value = *value;
    return true;
  }
  if (*value > rest_.size()) return false;
  field.bytes = rest_.substr(0, static_cast<std::size_t>(*value));
  rest_.remove_prefix(field.bytes.size());
  return true;
}

std::optional<ProtoField> ProtoReader::next() {
  if (rest_.empty() || !ok_) return std::nullopt;
  const std::string_view before = rest_;
  ProtoField field;
  const auto tag = varint();
  ok_ = tag && *tag >> 3U <= 0x1FFFFFFFU && read_value(static_cast<std::uint32_t>(*tag & 7U), field);
  if (!ok_) return std::nullopt;
  field.number = static_cast<std::uint32_t>(*tag >> 3U);
  field.whole = before.substr(0, before.size() - rest_.size());
  return field;
}

}  // namespace segserve::recording
