// SPDX-License-Identifier: Apache-2.0
#include "client/recording/mcap/mcap_records.hpp"

#include "client/recording/bytes/append.hpp"
#include "client/recording/bytes/byte_cursor.hpp"

namespace segserve::recording {
namespace {

constexpr std::uint64_t kMessageHead = 2 + 4 + 8 + 8;

}  // namespace

std::optional<Record> take_record(std::string_view& bytes) {
  ByteCursor cursor(bytes);
  Record record;
  record.opcode = cursor.number<std::uint8_t>();
  record.content = cursor.counted<std::uint64_t>();
  if (!cursor.ok()) return std::nullopt;
  bytes = cursor.rest();
  return record;
}

std::optional<std::pair<std::uint16_t, Schema>> parse_schema(std::string_view content) {
  ByteCursor cursor(content);
  const auto number = cursor.number<std::uint16_t>();
  Schema schema;
  schema.name = cursor.counted();
  schema.encoding = cursor.counted();
  schema.data = cursor.counted();
  if (!cursor.ok()) return std::nullopt;
  return std::pair(number, std::move(schema));
}

std::optional<std::pair<std::uint16_t, Channel>> parse_channel(std::string_view content) {
  ByteCursor cursor(content);
  const auto number = cursor.number<std::uint16_t>();
  Channel channel;
  channel.schema = cursor.number<std::uint16_t>();
  channel.topic = cursor.counted();
  channel.message_encoding = cursor.counted();
  ByteCursor map(cursor.counted());
  while (cursor.ok() && map.ok() && !map.rest().empty()) {
    std::string key(map.counted());
    channel.metadata[std::move(key)] = map.counted();
  }
  if (!cursor.ok() || !map.ok()) return std::nullopt;
  return std::pair(number, std::move(channel));
}

std::optional<Message> parse_message(std::string_view content) {
  ByteCursor cursor(content);
  Message message;
  message.channel = cursor.number<std::uint16_t>();
  message.sequence = cursor.number<std::uint32_t>();
  message.log_time = cursor.number<std::uint64_t>();
  message.publish_time = cursor.number<std::uint64_t>();
  message.data = cursor.rest();
  if (!cursor.ok()) return std::nullopt;
  return message;
}

std::optional<Footer> parse_footer(std::string_view content) {
  ByteCursor cursor(content);
  Footer footer;
  footer.summary_start = cursor.number<std::uint64_t>();
  footer.summary_offset_start = cursor.number<std::uint64_t>();
  footer.summary_crc = cursor.number<std::uint32_t>();
  if (!cursor.ok()) return std::nullopt;
  return footer;
}

std::optional<Chunk> parse_chunk(std::string_view content) {
  ByteCursor cursor(content);
  Chunk chunk;
  chunk.start_time = cursor.number<std::uint64_t>();
  chunk.end_time = cursor.number<std::uint64_t>();
  chunk.size = cursor.number<std::uint64_t>();
  chunk.crc = cursor.number<std::uint32_t>();
  chunk.compression = cursor.counted();
  const auto bytes = cursor.number<std::uint64_t>();
  if (!cursor.ok()) return std::nullopt;
  chunk.complete = bytes <= cursor.rest().size();
  chunk.records = chunk.complete ? cursor.take(bytes) : cursor.rest();
  return chunk;
}

std::optional<std::map<std::uint16_t, std::uint64_t>> parse_message_counts(std::string_view content) {
  constexpr std::uint64_t kBeforeTheMap = 8 + 2 + 4 + 4 + 4 + 4 + 8 + 8;
  ByteCursor cursor(content);
  cursor.take(kBeforeTheMap);
  ByteCursor map(cursor.counted());
  std::map<std::uint16_t, std::uint64_t> counts;
  while (map.ok() && !map.rest().empty()) {
    const auto channel = map.number<std::uint16_t>();
    counts[channel] = map.number<std::uint64_t>();
  }
  if (!cursor.ok() || !map.ok()) return std::nullopt;
  return counts;
}

void append_record(std::string& out, Opcode opcode, std::string_view content) {
  append_number<std::uint8_t>(out, opcode);
  append_counted<std::uint64_t>(out, content);
}

void append_schema(std::string& out, std::uint16_t number, const Schema& schema) {
  std::string content;
  append_number(content, number);
  for (const std::string* part : {&schema.name, &schema.encoding, &schema.data}) append_counted(content, *part);
  append_record(out, kSchema, content);
}

void append_channel(std::string& out, std::uint16_t number, const Channel& channel) {
  std::string map;
  for (const auto& [key, value] : channel.metadata) {
    append_counted(map, key);
    append_counted(map, value);
  }
  std::string content;
  append_number(content, number);
  append_number(content, channel.schema);
  append_counted(content, channel.topic);
  append_counted(content, channel.message_encoding);
  append_counted(content, map);
  append_record(out, kChannel, content);
}

void append_message(std::string& out, const Message& message) {
  append_number<std::uint8_t>(out, kMessage);
  append_number<std::uint64_t>(out, kMessageHead + message.data.size());
  append_number(out, message.channel);
  append_number(out, message.sequence);
  append_number(out, message.log_time);
  append_number(out, message.publish_time);
  out.append(message.data);
}

}  // namespace segserve::recording
