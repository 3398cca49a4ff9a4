// SPDX-License-Identifier: Apache-2.0
#include "client/segctl/recording_report.hpp"

#include <algorithm>

#include "client/segctl/exit_code.hpp"
#include "client/segctl/json_flag.hpp"
#include "client/segctl/messages.hpp"
#include "core/base/status_text.hpp"
#include "fmt/format.h"
#include "nlohmann/json.hpp"

namespace segserve::segctl {
namespace {

constexpr std::size_t kMostWarnings = 20;

}  // namespace

void RecordingReport::add(const client::TopicFrame& frame, const absl::StatusOr<client::Result>& result) {
  if (json_.wanted) add_line(frame, result);
  if (result.ok()) {
    add_result(*result);
  } else {
    add_failure(frame, result.status());
  }
}

void RecordingReport::add_line(const client::TopicFrame& frame, const absl::StatusOr<client::Result>& result) {
  nlohmann::ordered_json json = {{"input", input_},
                                 {"topic", topic_.name},
                                 {"frame", frame.index},
                                 {"log_time_ns", frame.log_time.time_since_epoch().count()},
                                 {"stamp_ns", frame.stamp.time_since_epoch().count()},
                                 {"frame_id", frame.frame_id},
                                 {"state", result.ok() ? "segmented" : "failed"},
                                 {"error", nullptr}};
  if (result.ok()) {
    json.update(to_json(Summary{.result = *result,
                                .input = input_,
                                .server = result->in_this_process ? "" : server_,
                                .timings = stage_timings(*result),
                                .with_segments = json_.with_segments}));
  } else {
    json["error"] = message_of(result.status());
  }
  lines_ += json_text(json);
}

void RecordingReport::add_failure(const client::TopicFrame& frame, const absl::Status& status) {
  if (failed_ == 0) first_failure_ = fmt::format("frame {}: {}", frame.index, message_of(status));
  ++failed_;
  all_are_bad_input_ = all_are_bad_input_ && exit_code(status) == kBadInput;
}

void RecordingReport::add_result(const client::Result& result) {
  const std::uint32_t segments = result.segmentation.segments;
  fewest_ = segmented_ == 0 ? segments : std::min(fewest_, segments);
  most_ = std::max(most_, segments);
  if (segmented_ == 0) view_rule_ = result.view_rule;
  ++segmented_;
  points_ += result.points;
  segments_ += segments;
  in_this_process_ = in_this_process_ || result.in_this_process;
  for (const codec::Warning& warning : result.warnings) {
    const bool is_told = of_frames_.size() < kMostWarnings || of_frames_.contains(warning.message);
    ++of_frames_[is_told ? warning.message : "there are more kinds of warnings than are told here"];
  }
}

std::string RecordingReport::json_lines(const std::vector<codec::Warning>& warnings) const {
  if (warnings.empty()) return lines_;
  const nlohmann::ordered_json json = {
      {"input", input_}, {"topic", topic_.name}, {"warnings", warnings_json(warnings)}};
  return lines_ + json_text(json);
}

std::vector<std::string> RecordingReport::warning_lines() const {
  std::vector<std::string> lines;
  lines.reserve(of_frames_.size());
  for (const auto& [message, frames] : of_frames_) {
    lines.push_back(fmt::format("{} ({} frame{})", message, frames, frames == 1 ? "" : "s"));
  }
  return lines;
}

std::string RecordingReport::text() const {
  std::string text = fmt::format("{}, {}: {} frames segmented, {} failed", input_, topic_.name, segmented_, failed_);
  if (segmented_ > 0) {
    const auto mean = [this](std::uint64_t sum) { return static_cast<double>(sum) / static_cast<double>(segmented_); };
    text += fmt::format("; {:.0f} points and {:.1f} segments a frame ({} to {})", mean(points_), mean(segments_),
                        fewest_, most_);
    text += fmt::format("\nfirst frame: {}", view_rule_);
  }
  text += "\n";
  for (const std::string& line : warning_lines()) text += fmt::format("warning: {}\n", line);
  return text;
}

void RecordingReport::print_warnings_of_frames() const {
  for (const std::string& line : warning_lines()) print_warning(line);
}

absl::Status RecordingReport::status(const std::vector<codec::Warning>& warnings) const {
  if (frames() == 0) {
    const std::string_view what = warnings.empty() ? "message in" : "frame that could be read in";
    return absl::InvalidArgumentError(fmt::format("{}: there is no {} the topic {}", input_, what, topic_.name));
  }
  if (failed_ == 0) return absl::OkStatus();
  const std::string message = fmt::format("{} of {} frames failed; {}", failed_, frames(), first_failure_);
  return all_are_bad_input_ ? absl::InvalidArgumentError(message) : absl::UnavailableError(message);
}

}  // namespace segserve::segctl
