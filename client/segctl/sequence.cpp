// SPDX-License-Identifier: Apache-2.0
#include "client/segctl/sequence.hpp"

#include <filesystem>
#include <system_error>
#include <utility>

#include "client/segctl/json_list.hpp"
#include "client/segctl/pose_json.hpp"
#include "core/base/status_macros.hpp"
#include "core/base/status_text.hpp"
#include "core/lab/eval/evaluation.hpp"
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

absl::StatusOr<std::vector<SequenceFrame>> read_sequence(const std::string& folder, double rate) {
  const std::string path = (fs::path(folder) / kSequenceFile).string();
  if (std::error_code error; fs::exists(path, error)) {
    return read_frames(path);
  }
  ASSIGN_OR_RETURN(const auto files, eval::scene_files(folder));
  std::vector<SequenceFrame> frames;
  frames.reserve(files.size());
  for (const fs::path& file : files) {
    frames.push_back({file.filename().string(), static_cast<double>(frames.size()) / rate, std::nullopt});
  }
  return frames;
}

}  // namespace segserve::segctl
