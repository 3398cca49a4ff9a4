// SPDX-License-Identifier: Apache-2.0
#include "client/segctl/segment_sequence.hpp"

#include <chrono>
#include <filesystem>
#include <map>
#include <optional>
#include <set>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "client/calls/local.hpp"
#include "client/segctl/exit_code.hpp"
#include "client/segctl/input_file.hpp"
#include "client/segctl/messages.hpp"
#include "client/segctl/output_folder.hpp"
#include "client/segctl/progress_bar.hpp"
#include "client/segctl/sequence.hpp"
#include "client/segctl/staged_output.hpp"
#include "client/segctl/summary.hpp"
#include "core/base/status_macros.hpp"
#include "core/base/status_text.hpp"
#include "fmt/format.h"
#include "nlohmann/json.hpp"
#include "segserve/codec/cloud_file.hpp"

namespace segserve::segctl {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;

class SequenceRun {
 public:
  explicit SequenceRun(const SegmentArguments& arguments) : arguments_(arguments), folder_(arguments.scenes.front()) {}

  absl::Status run();

 private:
  absl::Status open();
  absl::StatusOr<client::Result> segment(const SequenceFrame& frame, codec::LabeledCloud& content);
  absl::Status write(const SequenceFrame& frame, const codec::LabeledCloud& content, client::Result& result) const;
  absl::Status complete(const SequenceFrame& frame);
  void add_line(const SequenceFrame& frame, const absl::StatusOr<client::Result>& result);
  std::string text() const;

  const SegmentArguments& arguments_;
  const std::string folder_;
  SegmentRequest request_;
  std::vector<SequenceFrame> frames_;
  std::optional<client::Client> client_;
  std::string state_;  // of the tracks
  std::string lines_;
  std::map<std::string, std::size_t> events_;
  std::set<std::uint64_t> ids_;
  std::size_t failed_ = 0;
  bool in_this_process_ = false, all_are_bad_input_ = true;
  std::string first_failure_;
};

absl::Status SequenceRun::open() {
  RETURN_IF_ERROR(arguments_.track.check());
  ASSIGN_OR_RETURN(request_, arguments_.request());
  ASSIGN_OR_RETURN(Sequence sequence, read_sequence(folder_, arguments_.track.rate));
  frames_ = std::move(sequence.frames);
  if (!arguments_.out_dir.empty()) {
    std::error_code error;
    if (fs::equivalent(arguments_.out_dir, folder_, error)) {
      return absl::InvalidArgumentError(
          fmt::format("{} would be overwritten by its own output: use another folder for --out-dir", folder_));
    }
    RETURN_IF_ERROR(make_folder(arguments_.out_dir));
  }
  if (arguments_.local) return absl::OkStatus();
  ASSIGN_OR_RETURN(client_, arguments_.server.connect(arguments_.fallback_local));
  // Without this, every frame would fail for the same reason.
  const absl::Status reached = client_->server_info().status();
  return reached.ok() || (arguments_.fallback_local && absl::IsUnavailable(reached)) ? absl::OkStatus()
                                                                                     : or_locally(reached);
}

absl::StatusOr<client::Result> SequenceRun::segment(const SequenceFrame& frame, codec::LabeledCloud& content) {
  const std::string path = (fs::path(folder_) / frame.file).string();
  ASSIGN_OR_RETURN(const std::string bytes, read_input(path));
  ASSIGN_OR_RETURN(content, codec::decode_cloud(std::as_bytes(std::span(bytes)), {}, request_.read_options()));
  wire::TrackRequest tracking{.options = arguments_.track.options, .state = state_};
  tracking.options.time = frame.time;
  if (!arguments_.track.no_poses) tracking.options.pose = frame.pose;
  const Options options = codec::to_cloud(content.placement, request_.options);
  const wire::Outputs outputs{.labels = true, .segments = request_.segments};
  absl::StatusOr<client::Result> result;
  if (client_) {
    client::CallOptions call{.request_id = frame.file, .traceparent = request_.traceparent, .codec = request_.codec};
    call.outputs = outputs;
    call.outputs.compression = answer_compression(request_.codec);
    call.tracking = tracking;
    result = client_->segment(content.cloud, options, call);
  } else {
    result =
        client::segment_here(content.cloud, content.view_rule, options, outputs, StopToken(), std::nullopt, tracking);
  }
  if (!result.ok()) return result;
  take_file_facts(content, *result);
  return result;
}

absl::Status SequenceRun::write(const SequenceFrame& frame, const codec::LabeledCloud& content,
                                client::Result& result) const {
  if (arguments_.out_dir.empty()) return absl::OkStatus();
  const std::string name = fs::path(frame.file).stem().string() + ".pcd";
  const std::string path = (fs::path(arguments_.out_dir) / name).string();
  StagedOutput output;
  RETURN_IF_ERROR(output.announce(path));
  codec::EncodedFile file = arguments_.scene_output.encode_pcd(content, shown_labels(result));
  append_warnings(path, file.warnings, result.warnings);
  output.add(path, std::move(file.bytes));
  return output.commit();
}

void SequenceRun::add_line(const SequenceFrame& frame, const absl::StatusOr<client::Result>& result) {
  if (!arguments_.json.given()) return;
  Json json{{"file", frame.file}, {"time", frame.time}, {"state", result.ok() ? "segmented" : "failed"}};
  json["error"] = result.ok() ? Json() : Json(message_of(result.status()));
  if (result.ok()) {
    json.update(to_json(Summary{.result = *result,
                                .input = frame.file,
                                .server = result->in_this_process ? "" : arguments_.server.address(),
                                .timings = stage_timings(*result),
                                .with_segments = request_.segments}));
  }
  lines_ += json_text(json);
}

absl::Status SequenceRun::complete(const SequenceFrame& frame) {
  codec::LabeledCloud content;
  auto result = segment(frame, content);
  // Every other frame would fail, too.
  if (absl::IsUnavailable(result.status())) return result.status();
  if (!result.ok()) {
    add_line(frame, result);
    if (failed_++ == 0) first_failure_ = fmt::format("{}: {}", frame.file, message_of(result.status()));
    all_are_bad_input_ = all_are_bad_input_ && exit_code(result.status()) == kBadInput;
    return absl::OkStatus();
  }
  state_ = result->tracks->state;
  in_this_process_ = in_this_process_ || result->in_this_process;
  for (const TrackEvent& event : result->tracks->events) ++events_[std::string(name(event.kind))];
  for (const std::uint64_t id : result->tracks->track_of_segment) ids_.insert(id);
  ids_.erase(0);
  absl::Status written = write(frame, content, *result);
  add_line(frame, result);
  return written;
}

std::string SequenceRun::text() const {
  std::string text = fmt::format("{}: {} frames segmented, {} failed; {} tracks", folder_, frames_.size() - failed_,
                                 failed_, ids_.size());
  for (const auto& [name, count] : events_) text += fmt::format(", {} {}", count, name);
  return text + "\n";
}

absl::Status SequenceRun::run() {
  StagedOutput output;
  RETURN_IF_ERROR(arguments_.json.announce(output));
  RETURN_IF_ERROR(open());
  for (const SequenceFrame& frame : frames_) {
    RETURN_IF_ERROR(output.protect({(fs::path(folder_) / frame.file).string()}, true));
  }
  {
    const ProgressBar bar("segment");
    for (std::size_t i = 0; i < frames_.size(); ++i) {
      RETURN_IF_ERROR(complete(frames_[i]));
      bar.show(i + 1, frames_.size());
    }
  }
  if (in_this_process_ && !arguments_.local) warn_of_fallback(arguments_.server.address());
  arguments_.json.add(output, lines_);
  if (!arguments_.quiet && !output.uses_stdout()) output.add("-", text());
  RETURN_IF_ERROR(output.commit());
  if (failed_ == 0) return absl::OkStatus();
  const std::string message = fmt::format("{} of {} frames failed; {}", failed_, frames_.size(), first_failure_);
  return all_are_bad_input_ ? absl::InvalidArgumentError(message) : absl::UnavailableError(message);
}

}  // namespace

absl::Status segment_sequence(const SegmentArguments& arguments) { return SequenceRun(arguments).run(); }

}  // namespace segserve::segctl
