// SPDX-License-Identifier: Apache-2.0
#include "core/codec/las/las_records.hpp"

#include <fmt/format.h>

#include <array>
#include <string_view>
#include <utility>

#include "core/codec/common/scalar_type.hpp"
#include "core/codec/common/text_parsing.hpp"
#include "core/codec/las/las_fields.hpp"

namespace segserve::codec {
namespace {

struct Record {
  std::string_view user;
  std::uint16_t id = 0;
  std::span<const std::byte> payload;
};

/// The text up to the first zero byte.
std::string_view fixed_text(std::span<const std::byte> bytes) {
  const std::string_view text = as_text(bytes);
  return text.substr(0, text.find('\0'));
}

/// Takes a record off the front of `space`; false if it is not whole.
bool take_record(std::span<const std::byte>& space, LasRecordKind kind, Record& record) {
  constexpr std::size_t kUser = 2, kUserBytes = 16, kId = 18, kLength = 20;
  const bool is_short = kind == LasRecordKind::kShort;
  const std::size_t header_bytes = is_short ? kLasRecordHeaderBytes : kLasExtendedRecordHeaderBytes;
  if (space.size() < header_bytes) return false;
  const std::byte* const stored = space.data() + kLength;
  const std::uint64_t length = is_short ? load<std::uint16_t>(stored) : load<std::uint64_t>(stored);
  if (space.size() - header_bytes < length) return false;
  record.user = fixed_text(space.subspan(kUser, kUserBytes));
  record.id = load<std::uint16_t>(space.data() + kId);
  record.payload = space.subspan(header_bytes, static_cast<std::size_t>(length));
  space = space.subspan(header_bytes + record.payload.size());
  return true;
}

/// The numbers 1 to 10 of the specification's data types. 11 to 20 are pairs of them, 21 to 30 are triples.
constexpr std::array<ScalarType, 10> kExtraTypes{
    ScalarType::kUint8, ScalarType::kInt8,   ScalarType::kUint16, ScalarType::kInt16,   ScalarType::kUint32,
    ScalarType::kInt32, ScalarType::kUint64, ScalarType::kInt64,  ScalarType::kFloat32, ScalarType::kFloat64};

std::array<double, 3> three_doubles(const std::byte* bytes) {
  return {load<double>(bytes), load<double>(bytes + 8), load<double>(bytes + 16)};
}

/// Reads a description. The offset is not set.
LasExtra read_description(std::span<const std::byte> bytes) {
  constexpr std::size_t kType = 2, kOptions = 3, kName = 4, kNameBytes = 32, kScale = 112, kShift = 136;
  constexpr unsigned kHasScale = 8, kHasShift = 16;
  const auto type = static_cast<std::size_t>(bytes[kType]), options = static_cast<std::size_t>(bytes[kOptions]);
  LasExtra extra;
  extra.name = fixed_text(bytes.subspan(kName, kNameBytes));
  if (type == 0 || type > 3 * kExtraTypes.size()) {  // bytes that are not described, as many as the options say
    extra.count = type == 0 ? options : 0;
    return extra;
  }
  extra.type = kExtraTypes[(type - 1) % kExtraTypes.size()];
  extra.count = 1 + (type - 1) / kExtraTypes.size();
  if ((options & kHasScale) != 0) extra.scale = three_doubles(bytes.data() + kScale);
  if ((options & kHasShift) != 0) extra.shift = three_doubles(bytes.data() + kShift);
  return extra;
}

void warn(LasHeader& header, WarningReason reason, std::string message) {
  header.warnings.push_back({reason, std::move(message)});
}

void read_extra_bytes(std::span<const std::byte> payload, LasHeader& header) {
  std::size_t offset = las_layout(header.point_format).bytes;
  for (; payload.size() >= kLasExtraDescriptionBytes; payload = payload.subspan(kLasExtraDescriptionBytes)) {
    LasExtra extra = read_description(payload.first(kLasExtraDescriptionBytes));
    extra.offset = offset;
    const std::size_t bytes = extra.count * size_of(extra.type);
    if (bytes == 0 || bytes > header.record_bytes - offset) {
      warn(header, WarningReason::kAttributeNotKept,
           fmt::format("the extra bytes {} do not fit in a point, and are not kept", quoted(extra.name)));
      return;
    }
    offset += bytes;
    header.extra.push_back(std::move(extra));
  }
}

void use_record(const Record& record, LasHeader& header) {
  if (record.user == kLasSpecUser && record.id == kLasExtraBytesRecord && header.extra.empty()) {
    read_extra_bytes(record.payload, header);
  } else if (record.user == kLasStatementUser) {
    header.stated.take(as_text(record.payload));
    header.is_from_segserve = true;
  } else if (record.user == kLasProjectionUser) {
    header.reference_records.add(record.id, record.payload);
  }
}

}  // namespace

void read_las_records(std::span<const std::byte> space, LasRecordKind kind, std::uint32_t count, StopCheck& check,
                      LasHeader& header) {
  Record record;
  for (std::uint32_t i = 0; i < count && !check.after(1); ++i) {
    if (!take_record(space, kind, record)) {
      const bool is_short = kind == LasRecordKind::kShort;
      warn(header, WarningReason::kRowsNotUsed,
           fmt::format("only {} of {} {}variable length records fit {}; the others are not used", i, count,
                       is_short ? "" : "extended ", is_short ? "in front of the points" : "in the file"));
      return;
    }
    use_record(record, header);
  }
}

}  // namespace segserve::codec
