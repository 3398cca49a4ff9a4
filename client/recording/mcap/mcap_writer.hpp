// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "absl/status/status.h"
#include "client/recording/mcap/mcap_records.hpp"

namespace segserve::recording {

/// Writes an MCAP file as it goes: chunks of zstd with their indexes, and at the end the summary, from which readers
/// find topics, times and chunks without reading the rest. Holds one chunk, and some hundred bytes of index for each
/// chunk, in memory. Every function returns the first error of the sink.
class McapWriter {
 public:
  /// Takes the next bytes of the file.
  using Sink = std::function<absl::Status(std::string_view)>;

  /// `profile` is that of the messages, such as "ros2"; empty if they are of several kinds.
  McapWriter(Sink sink, std::string_view profile);

  /// Messages may only be written to channels that were defined before. Defining one again does nothing.
  absl::Status define(std::uint16_t number, const Schema& schema);
  absl::Status define(std::uint16_t number, const Channel& channel);
  absl::Status write(const Message& message);
  /// Copies an attachment or metadata of another file.
  absl::Status write(const Extra& extra);
  /// Writes the rest of the file. Nothing may be written after it.
  absl::Status finish();

 private:
  struct ChunkIndex {
    std::uint64_t start_time = 0, end_time = 0;
    std::uint64_t at = 0, bytes = 0;                      ///< of the record Chunk in the file
    std::map<std::uint16_t, std::uint64_t> indexes = {};  ///< where the message index of each channel begins
    std::uint64_t index_bytes = 0;
    std::uint64_t compressed = 0, size = 0;  ///< of the chunk's records
  };

  absl::Status put(std::string_view bytes);
  absl::Status end_chunk();
  absl::Status end_chunk_if_large();
  absl::Status put_message_indexes();
  std::string statistics() const;
  std::string chunk_indexes() const;

  Sink sink_;
  std::string begin_;           ///< of the file: goes out before anything else
  std::uint64_t at_ = 0;        ///< bytes written so far
  std::uint32_t data_crc_ = 0;  ///< of these
  std::string chunk_;           ///< records of the open chunk
  ChunkIndex open_;             ///< of it
  std::map<std::uint16_t, std::vector<std::pair<std::uint64_t, std::uint64_t>>> index_;  ///< of it: times and offsets
  std::vector<ChunkIndex> chunks_;
  std::map<std::uint16_t, std::string> schemas_, channels_;  ///< as records
  std::map<std::uint16_t, std::uint64_t> counts_;
  std::uint64_t messages_ = 0, start_time_ = 0, end_time_ = 0;
  std::uint32_t attachments_ = 0, metadata_ = 0;
  std::string attachment_indexes_, metadata_indexes_;  ///< records
};

}  // namespace segserve::recording
