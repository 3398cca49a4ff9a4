// SPDX-License-Identifier: Apache-2.0
#include "client/recording/mcap/mcap_reader.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "client/recording/bytes/byte_cursor.hpp"
#include "client/recording/bytes/crc32.hpp"
#include "client/recording/bytes/decompression.hpp"
#include "client/recording/mcap/mcap_summary.hpp"
#include "core/base/status_macros.hpp"

namespace segserve::recording {
namespace {

/// Whether a record of a file is read into memory. The others are skipped, however long they are.
bool is_used(std::uint8_t opcode) {
  return opcode == kSchema || opcode == kChannel || opcode == kMessage || opcode == kChunk || opcode == kAttachment ||
         opcode == kMetadata;
}

}  // namespace

absl::StatusOr<std::unique_ptr<MessageSource>> McapReader::open(RecordingFile file, const codec::DecodeLimits& limits) {
  std::unique_ptr<McapReader> reader(new McapReader(std::move(file), limits));
  RETURN_IF_ERROR(reader->file_.seek(kMcapMagic.size()));
  RETURN_IF_ERROR(reader->read_header());
  RETURN_IF_ERROR(reader->file_.seek(kMcapMagic.size()));
  return reader;
}

absl::Status McapReader::read_header() {
  constexpr std::uint64_t kEnough = 4096;
  RETURN_IF_ERROR(file_.read(std::min(kEnough, file_.left()), record_));
  std::string_view records = record_;
  const auto record = take_record(records);
  if (record && record->opcode == kHeader) profile_ = ByteCursor(record->content).counted();
  return absl::OkStatus();
}

absl::StatusOr<bool> McapReader::take_record_of_chunk(std::string_view& records, std::optional<Item>& item) {
  const auto record = take_record(records);
  if (!record) return false;
  if (record->opcode == kChunk) return true;  // Chunks within chunks are not allowed.
  return take(*record, item);
}

absl::StatusOr<bool> McapReader::read_record(const StopToken& stop, std::optional<Item>& item) {
  const std::uint64_t at = file_.offset();
  if (file_.left() < kRecordHead) {
    warn(fmt::format("the file ends at byte {} without a footer, as after a crash: it is read up to there", at));
    return false;
  }
  RETURN_IF_ERROR(file_.read(kRecordHead, record_));
  ByteCursor head(record_);
  const auto opcode = head.number<std::uint8_t>();
  const auto length = head.number<std::uint64_t>();
  if (opcode == kDataEnd || opcode == kFooter) return false;
  if (opcode == 0) {
    warn(fmt::format("there is no record at byte {}: what follows is not read", at));
    return false;
  }
  if (length > file_.left()) {
    RETURN_IF_ERROR(read_cut_off_record({opcode, {}}, at, stop));
    return false;
  }
  if (!is_used(opcode)) {
    RETURN_IF_ERROR(file_.seek(file_.offset() + length));
    return true;
  }
  RETURN_IF_ERROR(check_size("record", at, length));
  RETURN_IF_ERROR(file_.read(length, record_));
  if (opcode == kChunk) {
    RETURN_IF_ERROR(open_chunk(record_, at, stop));
    return true;
  }
  ASSIGN_OR_RETURN(const bool whole, take({opcode, record_}, item));
  if (!whole) warn_of_damaged("record", at);
  return true;
}

absl::Status McapReader::read_cut_off_record(Record head, std::uint64_t at, const StopToken& stop) {
  warn_of_end_within_record(at);
  if (head.opcode != kChunk || file_.left() > limits_.max_bytes) return absl::OkStatus();
  RETURN_IF_ERROR(file_.read(file_.left(), record_));
  return open_chunk(record_, at, stop);
}

absl::Status McapReader::open_chunk(std::string_view content, std::uint64_t at, const StopToken& stop) {
  const auto chunk = parse_chunk(content);
  if (!chunk) {
    warn_of_damaged("chunk", at);
    return absl::OkStatus();
  }
  RETURN_IF_ERROR(check_size("chunk", at, chunk->size));
  ASSIGN_OR_RETURN(Decompressed records, decompress(chunk->compression, chunk->records, chunk->size, stop));
  if (records.complete) {
    const std::uint32_t crc = chunk->crc == 0 ? 0 : crc32(0, records.bytes);
    if (crc != chunk->crc) {
      warn(fmt::format("the chunk at byte {} is damaged (CRC {:08x}, not {:08x}) and left out", at, crc, chunk->crc));
      return absl::OkStatus();
    }
  } else if (chunk->complete) {
    warn(
        fmt::format("the chunk at byte {} is damaged: it does not decompress to the {} bytes that it claims, and is "
                    "left out",
                    at, chunk->size));
    return absl::OkStatus();
  }
  open_records(std::move(records.bytes), at);
  return absl::OkStatus();
}

absl::StatusOr<bool> McapReader::take(const Record& record, std::optional<Item>& item) {
  switch (record.opcode) {
    case kSchema: {
      auto schema = parse_schema(record.content);
      if (!schema) return false;
      RETURN_IF_ERROR(keep_schema(*std::move(schema)));
      return true;
    }
    case kChannel: {
      auto channel = parse_channel(record.content);
      if (!channel) return false;
      RETURN_IF_ERROR(keep_channel(*std::move(channel)));
      return true;
    }
    case kMessage: {
      const auto message = parse_message(record.content);
      if (!message || !definitions_.channels.contains(message->channel)) return false;
      item = Item{message, {}};
      return true;
    }
    case kAttachment:
    case kMetadata:
      item = Item{std::nullopt, {record.opcode, record.content}};
      return true;
    default:
      return true;
  }
}

// Writers repeat definitions in every chunk; equal ones cost nothing.
absl::Status McapReader::keep_schema(std::pair<std::uint16_t, Schema> schema) {
  if (definitions_.schemas.contains(schema.first)) return absl::OkStatus();
  RETURN_IF_ERROR(
      count_definition(schema.second.name.size() + schema.second.encoding.size() + schema.second.data.size()));
  definitions_.schemas.insert(std::move(schema));
  return absl::OkStatus();
}

absl::Status McapReader::keep_channel(std::pair<std::uint16_t, Channel> channel) {
  if (definitions_.channels.contains(channel.first)) return absl::OkStatus();
  constexpr std::uint64_t kNode = 96;  // bytes that an entry of a map needs
  std::uint64_t bytes = channel.second.topic.size() + channel.second.message_encoding.size();
  for (const auto& [key, value] : channel.second.metadata) bytes += key.size() + value.size() + kNode;
  RETURN_IF_ERROR(count_definition(bytes));
  definitions_.channels.insert(std::move(channel));
  return absl::OkStatus();
}

absl::StatusOr<std::optional<Contents>> McapReader::indexed_contents() {
  const std::uint64_t here = file_.offset();
  ASSIGN_OR_RETURN(auto contents, read_mcap_summary(file_));
  RETURN_IF_ERROR(file_.seek(here));
  return contents;
}

}  // namespace segserve::recording
