// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "absl/status/status.h"
#include "client/segctl/summary.hpp"
#include "segserve/client/topic_reader.hpp"
#include "segserve/codec/warning.hpp"

namespace segserve::segctl {

/// Collects what became of the frames of a recording.
class RecordingReport {
 public:
  /// Whether the frames are told as JSON, with the statistics of their segments.
  struct Json {
    bool wanted = false;
    bool with_segments = false;
  };

  RecordingReport(std::string input, client::TopicInfo topic, std::string server, Json json)
      : input_(std::move(input)), topic_(std::move(topic)), server_(std::move(server)), json_(json) {}

  void add(const client::TopicFrame& frame, const absl::StatusOr<client::Result>& result);
  std::size_t frames() const { return segmented_ + failed_; }

  /// One JSON object a frame, each on a line, and one with the warnings of the recording as a whole if there are some.
  std::string json_lines(const std::vector<codec::Warning>& warnings) const;
  /// A few lines for people, with the warnings of frames.
  std::string text() const;
  /// Writes a line on standard error for each kind of warning of frames.
  void print_warnings_of_frames() const;
  /// Whether a frame was segmented without a server.
  bool in_this_process() const { return in_this_process_; }
  /// OK if no frame failed; else tells how many, and why the first of them did. INVALID_ARGUMENT if the recording has
  /// no frame, and warnings that may tell why.
  absl::Status status(const std::vector<codec::Warning>& warnings) const;

 private:
  void add_line(const client::TopicFrame& frame, const absl::StatusOr<client::Result>& result);
  void add_failure(const client::TopicFrame& frame, const absl::Status& status);
  void add_result(const client::Result& result);
  std::vector<std::string> warning_lines() const;

  std::string input_;
  client::TopicInfo topic_;
  std::string server_;
  Json json_;
  std::string lines_;
  std::size_t segmented_ = 0;
  std::uint64_t points_ = 0, segments_ = 0;
  std::uint32_t fewest_ = 0, most_ = 0;  ///< segments of a frame
  bool in_this_process_ = false;
  std::string view_rule_;                         ///< of the first frame
  std::map<std::string, std::size_t> of_frames_;  ///< warnings of frames, and how many have them
  std::size_t failed_ = 0;
  std::string first_failure_;      ///< the first frame that failed, and why
  bool all_are_bad_input_ = true;  ///< all that failed
};

}  // namespace segserve::segctl
