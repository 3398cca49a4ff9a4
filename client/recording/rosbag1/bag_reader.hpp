// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <string_view>

#include "client/recording/chunked_source.hpp"
#include "client/recording/rosbag1/bag_records.hpp"

namespace segserve::recording {

/// Reads a ROS 1 bag, also one that was not closed.
class BagReader final : public ChunkedSource {
 public:
  /// The file begins with the magic line. UNAVAILABLE if reading fails.
  static absl::StatusOr<std::unique_ptr<MessageSource>> open(RecordingFile file, const codec::DecodeLimits& limits);

  const std::string& profile() const override { return profile_; }
  absl::StatusOr<std::optional<Contents>> indexed_contents() override;

 private:
  using ChunkedSource::ChunkedSource;

  absl::StatusOr<bool> read_record(const StopToken& stop, std::optional<Item>& item) override;
  absl::StatusOr<bool> take_record_of_chunk(std::string_view& records, std::optional<Item>& item) override;

  /// Reads the header and the length of a record. Nothing, and a warning, if the file ends before.
  absl::StatusOr<std::optional<BagFields>> read_head(std::uint32_t& data_bytes);
  absl::Status open_chunk(const BagFields& fields, std::uint64_t at, const StopToken& stop);
  /// Makes an item of a record, or takes it as a connection. False if the record is damaged.
  absl::StatusOr<bool> take(const BagRecord& record, std::optional<Item>& item);
  absl::Status keep(BagConnection connection);

  std::string profile_ = "ros1";
  std::map<std::uint16_t, std::uint32_t> sequences_;  ///< messages so far, by channel
  std::string head_, data_;                           ///< of the record that is being read
};

}  // namespace segserve::recording
