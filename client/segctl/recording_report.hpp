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
  /// `with_segments` as in Summary.
  RecordingReport(std::string input, client::TopicInfo topic, std::string server, bool with_segments)
      : input_(std::move(input)), topic_(std::move(topic)), server_(std::move(server)), with_segments_(with_segments) {}

  void add(const client::TopicFrame& frame, const absl::StatusOr<client::Result>& result);
  std::size_t frames() const { return segmented_ + failures_.size(); }

  /// One JSON object a frame, each on a line.
  const std::string& json_lines() const { return lines_; }
  /// A few lines for people. `warnings` are those of the recording as a whole.
  std::string text(const std::vector<codec::Warning>& warnings) const;
  /// Writes a line on standard error for each kind of warning.
  void print_warnings(const std::vector<codec::Warning>& warnings) const;
  /// Whether a frame was segmented without a server.
  bool in_this_process() const { return in_this_process_; }
  /// OK if no frame failed; else tells how many, and why the first of them did.
  absl::Status status() const;

 private:
  struct Failure {
    std::uint64_t frame = 0;
    absl::Status status;
  };
  std::vector<std::string> warning_lines(const std::vector<codec::Warning>& warnings) const;

  std::string input_;
  client::TopicInfo topic_;
  std::string server_;
  bool with_segments_;
  std::string lines_;
  std::size_t segmented_ = 0;
  std::uint64_t points_ = 0, segments_ = 0;
  std::uint32_t fewest_ = 0, most_ = 0;  ///< segments of a frame
  bool in_this_process_ = false;
  std::string view_rule_;                         ///< of the first frame
  std::map<std::string, std::size_t> of_frames_;  ///< warnings of frames, and how many have them
  std::vector<Failure> failures_;
};

}  // namespace segserve::segctl
