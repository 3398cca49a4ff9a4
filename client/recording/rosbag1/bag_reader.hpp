// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "client/recording/bytes/recording_file.hpp"
#include "client/recording/message_source.hpp"
#include "client/recording/rosbag1/bag_records.hpp"

namespace segserve::recording {

/// Reads a ROS 1 bag from its beginning to its end, without its index, so that a bag that was not closed is read, too.
/// Damage becomes a warning that names the byte, as in McapReader.
class BagReader : public MessageSource {
 public:
  /// The file begins with the magic line. UNAVAILABLE if reading fails.
  static absl::StatusOr<std::unique_ptr<MessageSource>> open(RecordingFile file, const codec::DecodeLimits& limits);

  absl::StatusOr<std::optional<Item>> next(const StopToken& stop) override;
  const Definitions& definitions() const override { return definitions_; }
  const std::string& profile() const override { return profile_; }
  const std::vector<codec::Warning>& warnings() const override { return warnings_; }
  absl::StatusOr<std::optional<Contents>> indexed_contents() override;

 private:
  BagReader(RecordingFile file, const codec::DecodeLimits& limits) : file_(std::move(file)), limits_(limits) {}

  /// Reads one record of the file, which gives an item or opens a chunk. False at the end.
  absl::StatusOr<bool> read_record(const StopToken& stop, std::optional<Item>& item);
  /// Reads the header and the length of a record. Nothing, and a warning, if the file ends before.
  absl::StatusOr<std::optional<BagFields>> read_head(std::uint32_t& data_bytes);
  absl::Status open_chunk(const BagFields& fields, std::uint64_t at, const StopToken& stop);
  /// Makes an item of a record, or takes it as a connection. False if the record is damaged.
  absl::StatusOr<bool> take(const BagRecord& record, std::optional<Item>& item);
  absl::Status keep(BagConnection connection);
  void warn(std::string message);

  RecordingFile file_;
  codec::DecodeLimits limits_;
  std::string profile_ = "ros1";
  Definitions definitions_;
  std::uint64_t definition_bytes_ = 0;
  std::map<std::uint16_t, std::uint32_t> sequences_;  ///< messages so far, by channel
  std::vector<codec::Warning> warnings_;
  std::string head_, data_;         ///< of the record that is being read
  std::string chunk_;               ///< the records of the open chunk
  std::string_view rest_of_chunk_;  ///< those of them that were not read
  std::uint64_t chunk_at_ = 0;      ///< where the open chunk begins in the file
  bool at_end_ = false;
};

}  // namespace segserve::recording
