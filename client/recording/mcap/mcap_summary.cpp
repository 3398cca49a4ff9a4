// SPDX-License-Identifier: Apache-2.0
#include "client/recording/mcap/mcap_summary.hpp"

#include <string>
#include <utility>

#include "client/recording/bytes/crc32.hpp"
#include "client/recording/mcap/mcap_records.hpp"
#include "core/base/status_macros.hpp"

namespace segserve::recording {
namespace {

constexpr std::uint64_t kMaxSummaryBytes = std::uint64_t{64} << 20U;
/// The footer and the magic bytes behind it.
constexpr std::uint64_t kEndBytes = kRecordHead + kFooterBytes + kMcapMagic.size();
constexpr std::uint64_t kCrcBytes = 4;

/// The contents that the records of a summary tell of; nothing if there are no statistics, or one is damaged.
std::optional<Contents> parse_summary(std::string_view records) {
  Contents contents;
  bool has_counts = false;
  while (!records.empty()) {
    const auto record = take_record(records);
    if (!record) return std::nullopt;
    if (record->opcode == kSchema) {
      auto schema = parse_schema(record->content);
      if (!schema) return std::nullopt;
      contents.definitions.schemas.insert(*std::move(schema));
    } else if (record->opcode == kChannel) {
      auto channel = parse_channel(record->content);
      if (!channel) return std::nullopt;
      contents.definitions.channels.insert(*std::move(channel));
    } else if (record->opcode == kStatistics) {
      auto counts = parse_message_counts(record->content);
      if (!counts) return std::nullopt;
      contents.messages = *std::move(counts);
      has_counts = true;
    }
  }
  // A summary may leave out the channels, of which the data then tell.
  for (const auto& [channel, count] : contents.messages) {
    if (!contents.definitions.channels.contains(channel)) return std::nullopt;
  }
  return has_counts ? std::optional(std::move(contents)) : std::nullopt;
}

}  // namespace

absl::StatusOr<std::optional<Contents>> read_mcap_summary(RecordingFile& file) {
  if (file.size() < kMcapMagic.size() + kEndBytes) return std::nullopt;
  std::string end;
  RETURN_IF_ERROR(file.seek(file.size() - kEndBytes));
  RETURN_IF_ERROR(file.read(kEndBytes, end));
  std::string_view rest = end;
  const auto record = take_record(rest);
  if (!record || record->opcode != kFooter || rest != kMcapMagic) return std::nullopt;
  const auto footer = parse_footer(record->content);
  const std::uint64_t footer_at = file.size() - kEndBytes;
  if (!footer || footer->summary_start == 0 || footer->summary_start > footer_at ||
      footer_at - footer->summary_start > kMaxSummaryBytes) {
    return std::nullopt;
  }
  std::string summary;
  RETURN_IF_ERROR(file.seek(footer->summary_start));
  RETURN_IF_ERROR(file.read(footer_at - footer->summary_start, summary));
  const std::string_view checked_end(end.data(), kRecordHead + kFooterBytes - kCrcBytes);
  if (footer->summary_crc != 0 && crc32(crc32(0, summary), checked_end) != footer->summary_crc) return std::nullopt;
  return parse_summary(summary);
}

}  // namespace segserve::recording
