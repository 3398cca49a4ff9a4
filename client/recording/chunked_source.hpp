// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "client/recording/bytes/recording_file.hpp"
#include "client/recording/message_source.hpp"

namespace segserve::recording {

/// A file of records, of which some lie in compressed chunks. It is read from its beginning to its end, without its
/// index, so that a file that a crash cut off is read up to its last whole message. A record or chunk that is damaged
/// is left out. Each of these becomes a warning that names the byte.
class ChunkedSource : public MessageSource {
 public:
  absl::StatusOr<std::optional<Item>> next(const StopToken& stop) final;
  const Definitions& definitions() const final { return definitions_; }
  const std::vector<codec::Warning>& warnings() const final { return warnings_; }

 protected:
  ChunkedSource(RecordingFile file, const codec::DecodeLimits& limits);

  /// Reads one record of the file, which may give an item or open a chunk. False at the end of the data.
  virtual absl::StatusOr<bool> read_record(const StopToken& stop, std::optional<Item>& item) = 0;
  /// Takes one record off the front of an open chunk. False if it is damaged.
  virtual absl::StatusOr<bool> take_record_of_chunk(std::string_view& records, std::optional<Item>& item) = 0;

  /// Makes these the records of the open chunk, which begins at this byte of the file.
  void open_records(std::string records, std::uint64_t at);
  /// INVALID_ARGUMENT, as codec::over_limit makes it, if the record or chunk at this byte is larger than the limit.
  absl::Status check_size(std::string_view kind, std::uint64_t at, std::uint64_t bytes) const;
  /// INVALID_ARGUMENT if the definitions so far, and these bytes of one more, need more memory than any file should.
  absl::Status count_definition(std::uint64_t bytes);
  /// A few warnings are kept.
  void warn(std::string message);
  void warn_of_end_within_record(std::uint64_t at);
  void warn_of_damaged(std::string_view kind, std::uint64_t at);
  void forget_warnings() { warnings_.clear(); }

  RecordingFile file_;
  const codec::DecodeLimits limits_;
  Definitions definitions_;

 private:
  std::vector<codec::Warning> warnings_;
  std::uint64_t definition_bytes_ = 0;
  std::string chunk_;               ///< the records of the open chunk
  std::string_view rest_of_chunk_;  ///< those of them that were not read
  std::uint64_t chunk_at_ = 0;      ///< where the open chunk begins in the file
  bool at_end_ = false;
};

}  // namespace segserve::recording
