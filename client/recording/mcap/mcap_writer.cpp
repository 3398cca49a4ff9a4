// SPDX-License-Identifier: Apache-2.0
#include "client/recording/mcap/mcap_writer.hpp"

#include <algorithm>
#include <utility>

#include "client/recording/bytes/append.hpp"
#include "client/recording/bytes/byte_cursor.hpp"
#include "client/recording/bytes/crc32.hpp"
#include "core/base/status_macros.hpp"
#include "core/codec/common/zstd_block.hpp"

namespace segserve::recording {
namespace {

constexpr std::size_t kChunkBytes = std::size_t{4} << 20U;
constexpr int kZstdLevel = 1;
constexpr std::string_view kCompression = "zstd";
constexpr std::string_view kLibrary = "segserve";

/// Where an attachment or a piece of metadata lies, and what it says of itself.
std::string attachment_index(std::string_view content, std::uint64_t at, std::uint64_t bytes) {
  ByteCursor cursor(content);
  std::string index;
  append_number(index, at);
  append_number(index, bytes);
  append_number(index, cursor.number<std::uint64_t>());  // log time
  append_number(index, cursor.number<std::uint64_t>());  // creation time
  const std::string_view name = cursor.counted();
  const std::string_view media_type = cursor.counted();
  append_number(index, cursor.number<std::uint64_t>());  // bytes of the data
  append_counted(index, name);
  append_counted(index, media_type);
  return index;
}

std::string metadata_index(std::string_view content, std::uint64_t at, std::uint64_t bytes) {
  std::string index;
  append_number(index, at);
  append_number(index, bytes);
  append_counted(index, ByteCursor(content).counted());
  return index;
}

std::string joined(const std::map<std::uint16_t, std::string>& records) {
  std::string all;
  for (const auto& [number, record] : records) all += record;
  return all;
}

}  // namespace

McapWriter::McapWriter(Sink sink, std::string_view profile) : sink_(std::move(sink)) {
  std::string content;
  append_counted(content, profile);
  append_counted(content, kLibrary);
  begin_ = kMcapMagic;
  append_record(begin_, kHeader, content);
}

absl::Status McapWriter::put(std::string_view bytes) {
  if (!begin_.empty()) RETURN_IF_ERROR(put(std::exchange(begin_, {})));
  RETURN_IF_ERROR(sink_(bytes));
  data_crc_ = crc32(data_crc_, bytes);
  at_ += bytes.size();
  return absl::OkStatus();
}

absl::Status McapWriter::define(std::uint16_t number, const Schema& schema) {
  const auto [record, is_new] = schemas_.try_emplace(number);
  if (!is_new) return absl::OkStatus();
  append_schema(record->second, number, schema);
  chunk_ += record->second;
  return end_chunk_if_large();
}

absl::Status McapWriter::define(std::uint16_t number, const Channel& channel) {
  const auto [record, is_new] = channels_.try_emplace(number);
  if (!is_new) return absl::OkStatus();
  append_channel(record->second, number, channel);
  chunk_ += record->second;
  return end_chunk_if_large();
}

absl::Status McapWriter::write(const Message& message) {
  const std::uint64_t time = message.log_time;
  open_.start_time = index_.empty() ? time : std::min(open_.start_time, time);
  open_.end_time = index_.empty() ? time : std::max(open_.end_time, time);
  start_time_ = messages_ == 0 ? time : std::min(start_time_, time);
  end_time_ = messages_ == 0 ? time : std::max(end_time_, time);
  ++messages_;
  ++counts_[message.channel];
  index_[message.channel].emplace_back(time, chunk_.size());
  append_message(chunk_, message);
  return end_chunk_if_large();
}

absl::Status McapWriter::end_chunk_if_large() { return chunk_.size() < kChunkBytes ? absl::OkStatus() : end_chunk(); }

absl::Status McapWriter::end_chunk() {
  if (chunk_.empty()) return absl::OkStatus();
  ASSIGN_OR_RETURN(const std::string compressed, codec::zstd_compress(chunk_, kZstdLevel));
  std::string content;
  append_number(content, open_.start_time);
  append_number(content, open_.end_time);
  append_number<std::uint64_t>(content, chunk_.size());
  append_number(content, crc32(0, chunk_));
  append_counted(content, kCompression);
  append_counted<std::uint64_t>(content, compressed);
  std::string record;
  append_record(record, kChunk, content);
  RETURN_IF_ERROR(put(record));
  open_.at = at_ - record.size();
  open_.bytes = record.size();
  open_.compressed = compressed.size();
  open_.size = chunk_.size();
  RETURN_IF_ERROR(put_message_indexes());
  chunks_.push_back(std::exchange(open_, {}));
  index_.clear();
  chunk_.clear();
  return absl::OkStatus();
}

absl::Status McapWriter::put_message_indexes() {
  const std::uint64_t begin = at_;
  for (const auto& [channel, entries] : index_) {
    std::string times;
    for (const auto& [time, offset] : entries) {
      append_number<std::uint64_t>(times, time);
      append_number<std::uint64_t>(times, offset);
    }
    std::string content;
    append_number(content, channel);
    append_counted(content, times);
    std::string record;
    append_record(record, kMessageIndex, content);
    open_.indexes[channel] = at_;
    RETURN_IF_ERROR(put(record));
  }
  open_.index_bytes = at_ - begin;
  return absl::OkStatus();
}

absl::Status McapWriter::write(const Extra& extra) {
  std::string record;
  append_record(record, static_cast<Opcode>(extra.opcode), extra.content);
  RETURN_IF_ERROR(put(record));
  const std::uint64_t at = at_ - record.size();
  if (extra.opcode == kAttachment) {
    ++attachments_;
    append_record(attachment_indexes_, kAttachmentIndex, attachment_index(extra.content, at, record.size()));
  } else if (extra.opcode == kMetadata) {
    ++metadata_;
    append_record(metadata_indexes_, kMetadataIndex, metadata_index(extra.content, at, record.size()));
  }
  return absl::OkStatus();
}

std::string McapWriter::statistics() const {
  std::string counts;
  for (const auto& [channel, count] : counts_) {
    append_number(counts, channel);
    append_number(counts, count);
  }
  std::string content;
  append_number(content, messages_);
  append_number(content, static_cast<std::uint16_t>(schemas_.size()));
  append_number(content, static_cast<std::uint32_t>(channels_.size()));
  append_number(content, attachments_);
  append_number(content, metadata_);
  append_number(content, static_cast<std::uint32_t>(chunks_.size()));
  append_number(content, start_time_);
  append_number(content, end_time_);
  append_counted(content, counts);
  std::string record;
  append_record(record, kStatistics, content);
  return record;
}

std::string McapWriter::chunk_indexes() const {
  std::string records;
  for (const ChunkIndex& chunk : chunks_) {
    std::string offsets;
    for (const auto& [channel, at] : chunk.indexes) {
      append_number(offsets, channel);
      append_number(offsets, at);
    }
    std::string content;
    for (const std::uint64_t number : {chunk.start_time, chunk.end_time, chunk.at, chunk.bytes}) {
      append_number(content, number);
    }
    append_counted(content, offsets);
    append_number(content, chunk.index_bytes);
    append_counted(content, kCompression);
    append_number(content, chunk.compressed);
    append_number(content, chunk.size);
    append_record(records, kChunkIndex, content);
  }
  return records;
}

absl::Status McapWriter::finish() {
  RETURN_IF_ERROR(end_chunk());
  RETURN_IF_ERROR(put({}));  // An empty file has a beginning, too.
  std::string data_end;
  append_number(data_end, data_crc_);
  std::string end;
  append_record(end, kDataEnd, data_end);
  RETURN_IF_ERROR(put(end));

  const std::uint64_t summary_at = at_;
  std::string summary;
  std::string offsets;
  const auto add_group = [&](Opcode opcode, std::string_view records) {
    if (records.empty()) return;
    std::string content;
    append_number<std::uint8_t>(content, opcode);
    append_number<std::uint64_t>(content, summary_at + summary.size());
    append_number<std::uint64_t>(content, records.size());
    append_record(offsets, kSummaryOffset, content);
    summary += records;
  };
  add_group(kSchema, joined(schemas_));
  add_group(kChannel, joined(channels_));
  add_group(kStatistics, statistics());
  add_group(kChunkIndex, chunk_indexes());
  add_group(kAttachmentIndex, attachment_indexes_);
  add_group(kMetadataIndex, metadata_indexes_);

  const std::uint64_t offsets_at = summary_at + summary.size();
  summary += offsets;
  append_number<std::uint8_t>(summary, kFooter);
  append_number(summary, kFooterBytes);
  append_number(summary, summary_at);
  append_number(summary, offsets_at);
  append_number(summary, crc32(0, summary));
  summary += kMcapMagic;
  return put(summary);
}

}  // namespace segserve::recording
