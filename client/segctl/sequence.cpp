// SPDX-License-Identifier: Apache-2.0
#include "client/segctl/sequence.hpp"

#include <algorithm>
#include <filesystem>
#include <system_error>
#include <utility>

#include "client/segctl/batch_inputs.hpp"
#include "client/segctl/capture_time.hpp"
#include "client/segctl/json_list.hpp"
#include "client/segctl/pose_json.hpp"
#include "core/base/status_macros.hpp"
#include "core/base/status_text.hpp"
#include "fmt/format.h"
#include "nlohmann/json.hpp"

namespace segserve::segctl {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;

/// The frame, or what is wrong with it.
absl::StatusOr<SequenceFrame> parse_frame(const Json& json) {
  RETURN_IF_ERROR(check_members(json, {"file", "time", "rotation", "translation"}));
  if (!json.contains("file") || !json["file"].is_string()) {
    return absl::InvalidArgumentError("it has no \"file\"");
  }
  SequenceFrame frame;
  frame.file = json["file"].get<std::string>();
  if (fs::path(frame.file).filename() != frame.file) {
    return absl::InvalidArgumentError("its \"file\" is no name of a file in the folder");
  }
  if (!json.contains("time") || !json["time"].is_number()) return absl::InvalidArgumentError("it has no \"time\"");
  frame.time = json["time"].get<double>();
  if (!has_pose(json)) return frame;
  ASSIGN_OR_RETURN(frame.pose, parse_pose(json));
  return frame;
}

absl::StatusOr<std::vector<SequenceFrame>> read_frames(const std::string& path) {
  ASSIGN_OR_RETURN(const Json list, read_json_list(path, "frames"));
  std::vector<SequenceFrame> frames;
  frames.reserve(list.size());
  for (const Json& item : list) {
    auto frame = parse_frame(item);
    if (!frame.ok()) return with_prefix(fmt::format("{}: frame {}", path, frames.size()), frame.status());
    frames.push_back(*std::move(frame));
  }
  return frames;
}

/// Sets the times of frames whose names tell them; false if one does not, or if two are of the same time.
bool take_times_from_names(std::vector<SequenceFrame>& frames) {
  std::vector<SequenceFrame> timed = frames;
  for (SequenceFrame& frame : timed) {
    const auto time = capture_time(frame.file);
    if (!time) return false;
    frame.time = *time;
  }
  std::ranges::stable_sort(timed, {}, &SequenceFrame::time);
  if (std::ranges::adjacent_find(timed, {}, &SequenceFrame::time) != timed.end()) return false;
  frames = std::move(timed);
  return true;
}

}  // namespace

std::string sequence_json(const std::vector<SequenceFrame>& frames) {
  Json list = Json::array();
  for (const SequenceFrame& frame : frames) {
    Json json{{"file", frame.file}, {"time", frame.time}};
    if (frame.pose) add_pose(*frame.pose, json);
    list.push_back(std::move(json));
  }
  return Json{{"frames", std::move(list)}}.dump(1) + "\n";
}

absl::StatusOr<Sequence> read_sequence(const std::string& folder, double rate, codec::ReadableFor use) {
  const std::string path = (fs::path(folder) / kSequenceFile).string();
  if (std::error_code error; fs::exists(path, error)) {
    ASSIGN_OR_RETURN(auto frames, read_frames(path));
    return Sequence{std::move(frames), /*has_times=*/true};
  }
  if (std::error_code error; !fs::is_directory(folder, error)) {
    return absl::NotFoundError(fmt::format("there is no folder {}", folder));
  }
  ASSIGN_OR_RETURN(auto files, cloud_files_in(folder));
  std::erase_if(files, [use](const std::string& file) { return !codec::has_readable_extension(file, use); });
  if (files.empty()) {
    return absl::InvalidArgumentError(fmt::format("there is no file of a cloud in {}: none whose name ends in {}",
                                                  folder, codec::readable_extensions(use)));
  }
  Sequence sequence;
  for (const std::string& file : files) {
    const double time = static_cast<double>(sequence.frames.size()) / rate;
    sequence.frames.push_back({fs::path(file).filename().string(), time, std::nullopt});
  }
  sequence.has_times = take_times_from_names(sequence.frames);
  return sequence;
}

bool has_capture_times(const std::string& folder) {
  std::error_code error;
  if (fs::exists(fs::path(folder) / kSequenceFile, error)) return true;
  std::vector<SequenceFrame> frames;
  for (fs::directory_iterator entry(folder, error), end; !error && entry != end; entry.increment(error)) {
    const std::string name = entry->path().filename().string();
    if (codec::has_readable_extension(name, codec::ReadableFor::kSegmentation))
      frames.push_back({name, 0, std::nullopt});
  }
  return frames.size() > 1 && take_times_from_names(frames);
}

}  // namespace segserve::segctl
