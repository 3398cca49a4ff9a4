// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "client/recording/bytes/recording_file.hpp"
#include "client/recording/mcap/mcap_records.hpp"
#include "client/recording/message_source.hpp"

namespace segserve::recording {

/// Reads an MCAP file from its beginning to its end, without its index, so that a file that a crash cut off is read up
/// to its last whole message. A chunk whose CRC does not match is left out. What is behind a record that cannot be is
/// not read. Each of these becomes a warning that names the byte.
class McapReader : public MessageSource {
 public:
  /// The file begins with the magic bytes. UNAVAILABLE if reading fails.
  static absl::StatusOr<std::unique_ptr<MessageSource>> open(RecordingFile file, const codec::DecodeLimits& limits);

  absl::StatusOr<std::optional<Item>> next(const StopToken& stop) override;
  const Definitions& definitions() const override { return definitions_; }
  const std::string& profile() const override { return profile_; }
  const std::vector<codec::Warning>& warnings() const override { return warnings_; }
  absl::StatusOr<std::optional<Contents>> indexed_contents() override;

 private:
  McapReader(RecordingFile file, const codec::DecodeLimits& limits) : file_(std::move(file)), limits_(limits) {}

  /// Reads the profile, if the first record is a header.
  absl::Status read_header();
  /// Reads records of the file until one gives an item, or opens a chunk. False at the end of the data.
  absl::StatusOr<bool> read_record(const StopToken& stop, std::optional<Item>& item);
  /// The same for the next record of the open chunk.
  absl::StatusOr<bool> read_record_of_chunk(std::optional<Item>& item);
  absl::Status open_chunk(std::string_view content, std::uint64_t at, const StopToken& stop);
  /// Makes an item of a record, or takes it as a definition. False if the record is damaged.
  absl::StatusOr<bool> take(const Record& record, std::optional<Item>& item);
  absl::Status keep_schema(std::pair<std::uint16_t, Schema> schema);
  absl::Status keep_channel(std::pair<std::uint16_t, Channel> channel);
  absl::Status count_definition(std::uint64_t bytes);
  /// A record that the file has no room for: reads what there is of it.
  absl::Status read_cut_off_record(Record head, std::uint64_t at, const StopToken& stop);
  void warn(std::string message);

  RecordingFile file_;
  codec::DecodeLimits limits_;
  std::string profile_;
  Definitions definitions_;
  std::uint64_t definition_bytes_ = 0;
  std::vector<codec::Warning> warnings_;
  std::string record_;              ///< the record of the file that is being read
  std::string chunk_;               ///< the records of the open chunk
  std::string_view rest_of_chunk_;  ///< those of them that were not read
  std::uint64_t chunk_at_ = 0;      ///< where the open chunk begins in the file
  bool at_end_ = false;
};

}  // namespace segserve::recording
