// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <utility>

#include "client/recording/message_source.hpp"

// The records of MCAP, a format of recordings (https://mcap.dev/spec). All numbers are little-endian.
namespace segserve::recording {

inline constexpr std::string_view kMcapMagic("\x89MCAP0\r\n", 8);

/// The kinds of records that are read or written.
enum Opcode : std::uint8_t {
  kHeader = 0x01,
  kFooter = 0x02,
  kSchema = 0x03,
  kChannel = 0x04,
  kMessage = 0x05,
  kChunk = 0x06,
  kMessageIndex = 0x07,
  kChunkIndex = 0x08,
  kAttachment = 0x09,
  kAttachmentIndex = 0x0A,
  kStatistics = 0x0B,
  kMetadata = 0x0C,
  kMetadataIndex = 0x0D,
  kSummaryOffset = 0x0E,
  kDataEnd = 0x0F,
};

/// Bytes of a record's opcode and length.
inline constexpr std::uint64_t kRecordHead = 9;
/// Bytes of a record Footer after its head.
inline constexpr std::uint64_t kFooterBytes = 8 + 8 + 4;

/// A chunk, whose records are compressed.
struct Chunk {
  std::uint64_t start_time = 0, end_time = 0;  ///< of its messages, nanoseconds
  std::uint64_t size = 0;                      ///< of the records; a claim
  std::uint32_t crc = 0;                       ///< of the records; 0: not told
  std::string_view compression;
  std::string_view records;  ///< compressed
  bool complete = false;     ///< false: the file ends within `records`
};

struct Footer {
  std::uint64_t summary_start = 0;         ///< 0: there is no summary
  std::uint64_t summary_offset_start = 0;  ///< 0: there are no summary offsets
  std::uint32_t summary_crc = 0;           ///< 0: not told
};

/// A record in memory.
struct Record {
  std::uint8_t opcode = 0;
  std::string_view content;
};

/// Takes the next record from the front of `bytes`; nothing if it is not whole.
std::optional<Record> take_record(std::string_view& bytes);

// Each reads the content of a record; nothing if it is too short for what it claims.
std::optional<std::pair<std::uint16_t, Schema>> parse_schema(std::string_view content);
std::optional<std::pair<std::uint16_t, Channel>> parse_channel(std::string_view content);
std::optional<Message> parse_message(std::string_view content);
std::optional<Footer> parse_footer(std::string_view content);
/// The records of a chunk may be cut off, which Chunk::complete tells.
std::optional<Chunk> parse_chunk(std::string_view content);
/// The number of messages by channel, from a record Statistics.
std::optional<std::map<std::uint16_t, std::uint64_t>> parse_message_counts(std::string_view content);

// Each appends a whole record.
void append_record(std::string& out, Opcode opcode, std::string_view content);
void append_schema(std::string& out, std::uint16_t number, const Schema& schema);
void append_channel(std::string& out, std::uint16_t number, const Channel& channel);
void append_message(std::string& out, const Message& message);

}  // namespace segserve::recording
