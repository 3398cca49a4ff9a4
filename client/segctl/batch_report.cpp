// SPDX-License-Identifier: Apache-2.0
#include "client/segctl/batch_report.hpp"

#include <algorithm>
#include <memory>
#include <string>
#include <utility>

#include "client/segctl/exit_code.hpp"
#include "client/segctl/messages.hpp"
#include "client/segctl/server_flags.hpp"
#include "client/segctl/staged_output.hpp"
#include "client/segctl/summary.hpp"
#include "core/base/status_macros.hpp"
#include "core/base/status_text.hpp"
#include "core/lab/picture/picture.hpp"
#include "fmt/format.h"
#include "nlohmann/json.hpp"

namespace segserve::segctl {
namespace {

using Json = nlohmann::ordered_json;
using State = FileOutcome::State;

const char* name_of(State state) {
  switch (state) {
    case State::kSegmented:
      return "segmented";
    case State::kSkipped:
      return "skipped";
    case State::kOpen:
      return "unfinished";
    default:
      return "failed";
  }
}

Json to_json(const BatchInput& input, const FileOutcome& outcome) {
  const bool has_output = outcome.state == State::kSegmented || outcome.state == State::kSkipped;
  return {{"input", input.path},
          {"state", name_of(outcome.state)},
          {"output", has_output && !input.cloud_path.empty() ? Json(input.cloud_path) : Json()},
          {"points", has_output ? Json(outcome.points) : Json()},
          {"segments", has_output ? Json(outcome.segments) : Json()},
          {"warnings", warnings_json(outcome.warnings)},
          {"error", outcome.status.ok() ? Json() : Json(message_of(outcome.status))}};
}

std::size_t count(const std::vector<FileOutcome>& outcomes, State state) {
  return static_cast<std::size_t>(std::ranges::count(outcomes, state, &FileOutcome::state));
}

std::string counts_text(const std::vector<FileOutcome>& outcomes) {
  std::string text = fmt::format("{} segmented, {} done before, {} failed", count(outcomes, State::kSegmented),
                                 count(outcomes, State::kSkipped), count(outcomes, State::kFailed));
  if (const std::size_t open = count(outcomes, State::kOpen); open > 0) text += fmt::format(", {} not done", open);
  return text + "\n";
}

/// Why a batch that was stopped was stopped, how far it is, and that it can go on.
absl::Status stopped_status(const std::vector<FileOutcome>& outcomes, const absl::Status& stopped) {
  const std::size_t done = count(outcomes, State::kSegmented) + count(outcomes, State::kSkipped);
  const std::size_t failed = count(outcomes, State::kFailed);
  const std::string reason = message_of(stopped);
  return {stopped.code(), fmt::format("{}{}{} of {} done{}; run again to go on", reason, reason.empty() ? "" : ": ",
                                      done, outcomes.size(), failed > 0 ? fmt::format(", {} failed", failed) : "")};
}

void add_sheet(const BatchJob& job, const std::vector<FileOutcome>& outcomes, StagedOutput& output) {
  if (job.sheet == nullptr) return;
  auto image = std::make_shared<const picture::Image>(job.sheet->make(job.inputs, outcomes));
  output.add(job.sheet_path, [image](const std::string& target) { return picture::write_png(target, *image); });
}

}  // namespace

absl::Status report_batch(const BatchJob& job, const std::vector<FileOutcome>& outcomes, const absl::Status& stopped) {
  if (job.client && std::ranges::any_of(outcomes, &FileOutcome::in_this_process)) warn_of_fallback(job.server);
  StagedOutput output;
  RETURN_IF_ERROR(job.json->announce(output));
  if (job.sheet != nullptr) RETURN_IF_ERROR(output.announce(job.sheet_path));
  std::string lines;
  for (std::size_t i = 0; i < outcomes.size(); ++i) lines += json_text(to_json(job.inputs[i], outcomes[i]));
  job.json->add(output, lines);
  add_sheet(job, outcomes, output);
  if (!job.quiet && !output.uses_stdout()) output.add("-", counts_text(outcomes));
  RETURN_IF_ERROR(output.commit());
  for (std::size_t i = 0; i < outcomes.size() && !job.quiet; ++i) {
    for (const codec::Warning& warning : outcomes[i].warnings) {
      print_warning(fmt::format("{}: {}", job.inputs[i].path, warning.message));
    }
  }

  bool only_bad_input = true;
  for (std::size_t i = 0; i < outcomes.size(); ++i) {
    if (outcomes[i].state != State::kFailed) continue;
    print_error(fmt::format("{}: {}", job.inputs[i].path, message_of(outcomes[i].status)));
    only_bad_input = only_bad_input && exit_code(outcomes[i].status) == kBadInput;
  }
  if (count(outcomes, State::kOpen) > 0) return stopped_status(outcomes, stopped);
  const std::size_t failed = count(outcomes, State::kFailed);
  if (failed == 0) return absl::OkStatus();
  const std::string message = fmt::format("{} of {} files failed", failed, outcomes.size());
  return only_bad_input ? absl::InvalidArgumentError(message) : absl::UnavailableError(message);
}

}  // namespace segserve::segctl
