// SPDX-License-Identifier: Apache-2.0
#include "client/recording/rosbag1/bag_records.hpp"

#include <cstring>

#include "client/recording/bytes/byte_cursor.hpp"

namespace segserve::recording {
namespace {

constexpr std::uint64_t kNanoseconds = 1'000'000'000;

/// The number that MCAP, where 0 means "no schema", gives a connection.
std::optional<std::uint16_t> connection_number(const BagFields& fields) {
  constexpr std::uint64_t kLargest = 0xFFFE;
  const auto number = bag_number(fields, "conn", sizeof(std::uint32_t));
  if (!number || *number >= kLargest) return std::nullopt;
  return static_cast<std::uint16_t>(*number + 1);
}

std::string text(const BagFields& fields, std::string_view name) {
  const auto found = fields.find(name);
  return found == fields.end() ? "" : std::string(found->second);
}

}  // namespace

std::optional<BagFields> parse_bag_fields(std::string_view bytes) {
  BagFields fields;
  ByteCursor cursor(bytes);
  while (cursor.ok() && !cursor.rest().empty()) {
    const std::string_view field = cursor.counted();
    const auto equals = field.find('=');
    if (equals == std::string_view::npos) return std::nullopt;
    fields[field.substr(0, equals)] = field.substr(equals + 1);
  }
  return cursor.ok() ? std::optional(std::move(fields)) : std::nullopt;
}

std::optional<std::uint64_t> bag_number(const BagFields& fields, std::string_view name, std::size_t bytes) {
  const auto found = fields.find(name);
  if (found == fields.end() || found->second.size() != bytes || bytes > sizeof(std::uint64_t)) return std::nullopt;
  std::uint64_t value = 0;
  std::memcpy(&value, found->second.data(), bytes);
  return value;
}

std::uint8_t bag_op(const BagFields& fields) {
  return static_cast<std::uint8_t>(bag_number(fields, "op", 1).value_or(0));
}

std::optional<BagRecord> take_bag_record(std::string_view& bytes) {
  ByteCursor cursor(bytes);
  const std::string_view header = cursor.counted();
  BagRecord record;
  record.data = cursor.counted();
  auto fields = parse_bag_fields(header);
  if (!cursor.ok() || !fields) return std::nullopt;
  record.fields = *std::move(fields);
  bytes = cursor.rest();
  return record;
}

std::optional<BagConnection> parse_bag_connection(const BagRecord& record) {
  const auto number = connection_number(record.fields);
  const auto header = parse_bag_fields(record.data);
  if (!number || !header || !record.fields.contains("topic") || !header->contains("type")) return std::nullopt;
  BagConnection connection;
  connection.number = *number;
  connection.schema = {text(*header, "type"), "ros1msg", text(*header, "message_definition")};
  connection.channel = {*number, text(record.fields, "topic"), "ros1", {}};
  for (const char* key : {"md5sum", "callerid", "latching"}) {
    if (header->contains(key)) connection.channel.metadata[key] = text(*header, key);
  }
  return connection;
}

std::optional<Message> parse_bag_message(const BagRecord& record) {
  const auto number = connection_number(record.fields);
  const auto time = bag_number(record.fields, "time", sizeof(std::uint64_t));
  if (!number || !time) return std::nullopt;
  Message message;
  message.channel = *number;
  message.log_time = (*time & 0xFFFFFFFFU) * kNanoseconds + (*time >> 32U);
  message.publish_time = message.log_time;
  message.data = record.data;
  return message;
}

}  // namespace segserve::recording
