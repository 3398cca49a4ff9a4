// SPDX-License-Identifier: Apache-2.0
#include "client/recording/rosbag1/bag_reader.hpp"

#include <fmt/format.h>

#include <cstring>
#include <utility>

#include "client/recording/bytes/byte_cursor.hpp"
#include "client/recording/bytes/decompression.hpp"
#include "core/base/status_macros.hpp"

namespace segserve::recording {
namespace {

/// The most that the index of a bag may have.
constexpr std::uint64_t kMaxIndexBytes = std::uint64_t{64} << 20U;
constexpr std::uint32_t kMaxHeadBytes = 1U << 20U;

bool is_read(std::uint8_t op) { return op == kBagMessage || op == kBagChunk || op == kBagConnection; }

/// The number of messages by channel, from a record that tells of a chunk. False if it is damaged.
bool add_counts(std::string_view pairs, std::map<std::uint16_t, std::uint64_t>& counts) {
  ByteCursor cursor(pairs);
  while (cursor.ok() && !cursor.rest().empty()) {
    const auto connection = cursor.number<std::uint32_t>();
    counts[static_cast<std::uint16_t>(connection + 1)] += cursor.number<std::uint32_t>();
  }
  return cursor.ok();
}

std::optional<Contents> parse_index(std::string_view records) {
  Contents contents;
  while (!records.empty()) {
    const auto record = take_bag_record(records);
    if (!record) return std::nullopt;
    if (bag_op(record->fields) == kBagConnection) {
      auto connection = parse_bag_connection(*record);
      if (!connection) return std::nullopt;
      contents.definitions.schemas.emplace(connection->number, std::move(connection->schema));
      contents.definitions.channels.emplace(connection->number, std::move(connection->channel));
    } else if (bag_op(record->fields) == kBagChunkInfo && !add_counts(record->data, contents.messages)) {
      return std::nullopt;
    }
  }
  return contents;
}

}  // namespace

absl::StatusOr<std::unique_ptr<MessageSource>> BagReader::open(RecordingFile file, const codec::DecodeLimits& limits) {
  std::unique_ptr<BagReader> reader(new BagReader(std::move(file), limits));
  RETURN_IF_ERROR(reader->file_.seek(kBagMagic.size()));
  return reader;
}

absl::StatusOr<bool> BagReader::take_record_of_chunk(std::string_view& records, std::optional<Item>& item) {
  const auto record = take_bag_record(records);
  if (!record) return false;
  return take(*record, item);
}

absl::StatusOr<std::optional<BagFields>> BagReader::read_head(std::uint32_t& data_bytes) {
  const std::uint64_t at = file_.offset();
  const auto read_length = [this](std::uint32_t& length) -> absl::StatusOr<bool> {
    if (file_.left() < sizeof(length)) return false;
    RETURN_IF_ERROR(file_.read(sizeof(length), data_));
    std::memcpy(&length, data_.data(), sizeof(length));
    return true;
  };
  std::uint32_t length = 0;
  ASSIGN_OR_RETURN(bool is_whole, read_length(length));
  is_whole = is_whole && length <= file_.left() && length <= kMaxHeadBytes;
  if (is_whole) {
    RETURN_IF_ERROR(file_.read(length, head_));
    ASSIGN_OR_RETURN(is_whole, read_length(data_bytes));
  }
  auto fields = is_whole ? parse_bag_fields(head_) : std::nullopt;
  if (!fields) warn(fmt::format("the record at byte {} is cut off or damaged: the bag is read up to there", at));
  return fields;
}

absl::StatusOr<bool> BagReader::read_record(const StopToken& stop, std::optional<Item>& item) {
  const std::uint64_t at = file_.offset();
  if (file_.left() == 0) return false;
  std::uint32_t bytes = 0;
  ASSIGN_OR_RETURN(auto fields, read_head(bytes));
  if (!fields) return false;
  const std::uint8_t op = bag_op(*fields);
  const bool is_whole = bytes <= file_.left();
  if (!is_whole) {
    warn_of_end_within_record(at);
    if (op != kBagChunk) return false;
  }
  if (!is_read(op)) {
    RETURN_IF_ERROR(file_.seek(file_.offset() + bytes));
    return true;
  }
  RETURN_IF_ERROR(check_size("record", at, bytes));
  RETURN_IF_ERROR(file_.read(is_whole ? bytes : file_.left(), data_));
  if (op == kBagChunk) {
    RETURN_IF_ERROR(open_chunk(*fields, at, stop));
    return is_whole;
  }
  ASSIGN_OR_RETURN(const bool taken, take({*std::move(fields), data_}, item));
  if (!taken) warn_of_damaged("record", at);
  return true;
}

absl::Status BagReader::open_chunk(const BagFields& fields, std::uint64_t at, const StopToken& stop) {
  const auto size = bag_number(fields, "size", sizeof(std::uint32_t));
  const auto compression = fields.find("compression");
  if (!size || compression == fields.end()) {
    warn_of_damaged("chunk", at);
    return absl::OkStatus();
  }
  RETURN_IF_ERROR(check_size("chunk", at, *size));
  ASSIGN_OR_RETURN(Decompressed records, decompress(compression->second, data_, *size, stop));
  if (!records.complete) {
    warn(fmt::format(
        "the chunk at byte {} does not decompress to the {} bytes that it claims: only its beginning is read", at,
        *size));
  }
  open_records(std::move(records.bytes), at);
  return absl::OkStatus();
}

absl::StatusOr<bool> BagReader::take(const BagRecord& record, std::optional<Item>& item) {
  const std::uint8_t op = bag_op(record.fields);
  if (op == kBagConnection) {
    auto connection = parse_bag_connection(record);
    if (!connection) return false;
    RETURN_IF_ERROR(keep(*std::move(connection)));
  } else if (op == kBagMessage) {
    auto message = parse_bag_message(record);
    if (!message || !definitions_.channels.contains(message->channel)) return false;
    message->sequence = sequences_[message->channel]++;
    item = Item{message, {}};
  }
  return true;
}

absl::Status BagReader::keep(BagConnection connection) {
  if (definitions_.channels.contains(connection.number)) return absl::OkStatus();
  std::uint64_t bytes = connection.schema.name.size() + connection.schema.data.size() + connection.channel.topic.size();
  for (const auto& [key, value] : connection.channel.metadata) bytes += key.size() + value.size();
  RETURN_IF_ERROR(count_definition(bytes));
  definitions_.schemas.emplace(connection.number, std::move(connection.schema));
  definitions_.channels.emplace(connection.number, std::move(connection.channel));
  return absl::OkStatus();
}

absl::StatusOr<std::optional<Contents>> BagReader::indexed_contents() {
  const std::uint64_t here = file_.offset();
  std::uint32_t bytes = 0;
  ASSIGN_OR_RETURN(const auto fields, read_head(bytes));
  forget_warnings();  // They come again when the file is read.
  const auto index_at = fields && bag_op(*fields) == kBagHeader ? bag_number(*fields, "index_pos", 8) : std::nullopt;
  std::optional<Contents> contents;
  if (index_at && *index_at > here && *index_at < file_.size() && file_.size() - *index_at <= kMaxIndexBytes) {
    RETURN_IF_ERROR(file_.seek(*index_at));
    RETURN_IF_ERROR(file_.read(file_.left(), data_));
    contents = parse_index(data_);
  }
  RETURN_IF_ERROR(file_.seek(here));
  return contents;
}

}  // namespace segserve::recording
