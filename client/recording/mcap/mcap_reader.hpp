// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <utility>

#include "client/recording/chunked_source.hpp"
#include "client/recording/mcap/mcap_records.hpp"

namespace segserve::recording {

/// Reads an MCAP file. A chunk whose CRC does not match is left out, and so is the rest of the file behind a record
/// that cannot be one.
class McapReader final : public ChunkedSource {
 public:
  /// The file begins with the magic bytes. UNAVAILABLE if reading fails.
  static absl::StatusOr<std::unique_ptr<MessageSource>> open(RecordingFile file, const codec::DecodeLimits& limits);

  const std::string& profile() const override { return profile_; }
  absl::StatusOr<std::optional<Contents>> indexed_contents() override;

 private:
  using ChunkedSource::ChunkedSource;

  absl::StatusOr<bool> read_record(const StopToken& stop, std::optional<Item>& item) override;
  absl::StatusOr<bool> take_record_of_chunk(std::string_view& records, std::optional<Item>& item) override;

  /// Reads the profile, if the first record is a header.
  absl::Status read_header();
  absl::Status open_chunk(std::string_view content, std::uint64_t at, const StopToken& stop);
  /// Makes an item of a record, or takes it as a definition. False if the record is damaged.
  absl::StatusOr<bool> take(const Record& record, std::optional<Item>& item);
  absl::Status keep_schema(std::pair<std::uint16_t, Schema> schema);
  absl::Status keep_channel(std::pair<std::uint16_t, Channel> channel);
  /// A record that the file has no room for: reads what there is of it.
  absl::Status read_cut_off_record(Record head, std::uint64_t at, const StopToken& stop);

  std::string profile_;
  std::string record_;  ///< the record of the file that is being read
};

}  // namespace segserve::recording
