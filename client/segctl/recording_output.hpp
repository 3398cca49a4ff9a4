// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <cstdio>
#include <memory>
#include <optional>
#include <span>
#include <string>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "client/recording/mcap/mcap_writer.hpp"
#include "client/recording/topic/frame_reader.hpp"

namespace segserve::segctl {

/// Writes a recording as it goes, under a temporary name until it is whole, or to standard output for "-".
class RecordingOutput {
 public:
  /// UNAVAILABLE if the file cannot be written.
  static absl::StatusOr<RecordingOutput> create(const std::string& path, const std::string& profile);
  RecordingOutput(RecordingOutput&&) noexcept = default;
  RecordingOutput& operator=(RecordingOutput&&) = delete;
  /// Removes the temporary file unless `finish` has renamed it.
  ~RecordingOutput();

  /// Copies a message or an extra.
  absl::Status copy(const recording::Item& item, const recording::Definitions& definitions);
  /// Writes the message of a frame with its labels or, without labels, as it was. Of images it writes a cloud, on a
  /// topic of its own, or nothing.
  absl::Status write(const recording::RecordedFrame& frame, std::optional<std::span<const std::uint32_t>> labels,
                     const recording::FrameReader& reader);
  /// Defines a channel, so that it is listed even if it has no messages.
  absl::Status define(std::uint16_t channel, const recording::Definitions& definitions);
  /// Completes the file and gives it its name.
  absl::Status finish();

 private:
  struct Closer {
    void operator()(std::FILE* file) const {
      if (file != stdout) std::fclose(file);
    }
  };
  using File = std::unique_ptr<std::FILE, Closer>;

  RecordingOutput(std::string path, std::string temporary, File file, const std::string& profile);

  std::string path_, temporary_;  ///< `temporary_` is empty if there is nothing to rename
  File file_;
  std::unique_ptr<recording::McapWriter> writer_;
};

}  // namespace segserve::segctl
