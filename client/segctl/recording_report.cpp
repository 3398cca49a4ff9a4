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

void RecordingReport::add(const client::TopicFrame& frame, const absl::StatusOr<client::Result>& result) {
  nlohmann::ordered_json json = {{"input", input_},
                                 {"topic", topic_.name},
                                 {"frame", frame.index},
                                 {"log_time_ns", frame.log_time.time_since_epoch().count()},
                                 {"stamp_ns", frame.stamp.time_since_epoch().count()},
                                 {"frame_id", frame.frame_id},
                                 {"state", result.ok() ? "segmented" : "failed"},
                                 {"error", nullptr}};
  if (!result.ok()) {
    json["error"] = message_of(result.status());
    failures_.push_back({frame.index, result.status()});
  } else {
    json.update(to_json(Summary{.result = *result,
                                .input = input_,
                                .server = result->in_this_process ? "" : server_,
                                .timings = stage_timings(*result),
                                .with_segments = with_segments_}));
    const std::uint32_t segments = result->segmentation.segments;
    fewest_ = segmented_ == 0 ? segments : std::min(fewest_, segments);
    most_ = std::max(most_, segments);
    if (segmented_ == 0) view_rule_ = result->view_rule;
    ++segmented_;
    points_ += result->points;
    segments_ += segments;
    in_this_process_ = in_this_process_ || result->in_this_process;
    for (const codec::Warning& warning : result->warnings) ++of_frames_[warning.message];
  }
  lines_ += json_text(json);
}

std::vector<std::string> RecordingReport::warning_lines(const std::vector<codec::Warning>& warnings) const {
  std::vector<std::string> lines;
  for (const codec::Warning& warning : warnings) lines.push_back(warning.message);
  for (const auto& [message, frames] : of_frames_) {
    lines.push_back(fmt::format("{} ({} frame{})", message, frames, frames == 1 ? "" : "s"));
  }
  return lines;
}

std::string RecordingReport::text(const std::vector<codec::Warning>& warnings) const {
  std::string text =
      fmt::format("{}, {}: {} frames segmented, {} failed", input_, topic_.name, segmented_, failures_.size());
  if (segmented_ > 0) {
    const auto mean = [this](std::uint64_t sum) { return static_cast<double>(sum) / static_cast<double>(segmented_); };
    text += fmt::format("; {:.0f} points and {:.1f} segments a frame ({} to {})", mean(points_), mean(segments_),
                        fewest_, most_);
    text += fmt::format("\nfirst frame: {}", view_rule_);
  }
  text += "\n";
  for (const std::string& line : warning_lines(warnings)) text += fmt::format("warning: {}\n", line);
  return text;
}

void RecordingReport::print_warnings(const std::vector<codec::Warning>& warnings) const {
  for (const std::string& line : warning_lines(warnings)) print_warning(line);
}

absl::Status RecordingReport::status() const {
  if (failures_.empty()) return absl::OkStatus();
  const bool is_bad_input =
      std::ranges::all_of(failures_, [](const Failure& failure) { return exit_code(failure.status) == kBadInput; });
  const Failure& first = failures_.front();
  const std::string message = fmt::format("{} of {} frames failed; frame {}: {}", failures_.size(), frames(),
                                          first.frame, message_of(first.status));
  return is_bad_input ? absl::InvalidArgumentError(message) : absl::UnavailableError(message);
}

}  // namespace segserve::segctl
