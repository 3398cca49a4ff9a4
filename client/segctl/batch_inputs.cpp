// SPDX-License-Identifier: Apache-2.0
#include "client/segctl/batch_inputs.hpp"

#include <algorithm>
#include <array>
#include <filesystem>
#include <fstream>
#include <map>
#include <set>
#include <string_view>
#include <system_error>

#include "client/segctl/json_flag.hpp"
#include "client/segctl/messages.hpp"
#include "client/segctl/output_names.hpp"
#include "core/base/status_macros.hpp"
#include "fmt/format.h"
#include "nlohmann/json.hpp"
#include "segserve/codec/cloud_file.hpp"
#include "segserve/codec/file_format.hpp"

namespace segserve::segctl {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;

/// Whether an entry of a folder is to be read. A link that leads nowhere is, so that its fault is told.
bool is_cloud_file(const fs::directory_entry& entry) {
  std::error_code error;
  const bool is_dangling = entry.is_symlink(error) && !entry.exists(error);
  return (is_dangling || entry.is_regular_file(error)) && codec::is_cloud_file(entry.path().string());
}

/// Whether the name is that of a file with clouds that a folder's batch does not read.
bool is_left_out(const fs::path& path) {
  constexpr std::array<std::string_view, 9> kExtensions{".laz", ".e57", ".mcap", ".bag", ".db3",
                                                        ".stl", ".drc", ".ptx",  ".zip"};
  return std::ranges::find(kExtensions, path.extension().string()) != kExtensions.end();
}

}  // namespace

absl::StatusOr<std::vector<std::string>> cloud_files_in(const std::string& folder) {
  std::error_code error;
  std::vector<std::string> found, left_out;
  for (fs::directory_iterator entry(folder, error), end; !error && entry != end; entry.increment(error)) {
    if (is_cloud_file(*entry)) {
      found.push_back(entry->path().string());
    } else if (is_left_out(entry->path())) {
      left_out.push_back(entry->path().filename().string());
    }
  }
  if (!left_out.empty()) {
    std::ranges::sort(left_out);
    print_warning(fmt::format("{}: left out {}, which cannot be read in a folder", folder, fmt::join(left_out, ", ")));
  }
  if (error) return absl::UnavailableError(fmt::format("cannot read folder {}: {}", folder, error.message()));
  std::ranges::sort(found);
  return found;
}

namespace {

absl::StatusOr<std::vector<std::string>> expand_folders(const std::vector<std::string>& paths) {
  std::vector<std::string> files;
  for (const std::string& path : paths) {
    std::error_code error;
    if (path == "-") return absl::InvalidArgumentError("standard input has no name for --out-dir and --contact-sheet");
    if (fs::is_directory(path, error)) {
      ASSIGN_OR_RETURN(const auto found, cloud_files_in(path));
      files.insert(files.end(), found.begin(), found.end());
    } else if (fs::exists(path, error)) {
      files.push_back(path);
    } else {
      return absl::NotFoundError(fmt::format("there is no {}", path));
    }
  }
  if (files.empty())
    return absl::InvalidArgumentError(
        fmt::format("there is no file of a cloud in {}: none whose name ends in {}; recordings are segmented one at a "
                    "time, by their names",
                    fmt::join(paths, ", "), codec::readable_extensions()));
  std::set<fs::path> seen;
  std::erase_if(files, [&](const auto& file) { return !seen.insert(fs::absolute(file).lexically_normal()).second; });
  return files;
}

// These functions read a summary. Other programs may have written the file.

Json member(const Json& json, const char* name) {
  return json.is_object() && json.contains(name) ? json[name] : Json();
}

std::string text(const Json& json) { return json.is_string() ? json.get<std::string>() : ""; }

std::uint64_t number(const Json& json) { return json.is_number_unsigned() ? json.get<std::uint64_t>() : 0; }

}  // namespace

absl::StatusOr<std::vector<BatchInput>> batch_inputs(const std::vector<std::string>& paths,
                                                     const std::string& out_dir) {
  ASSIGN_OR_RETURN(const auto files, expand_folders(paths));
  std::vector<BatchInput> inputs;
  if (out_dir.empty()) {
    for (const std::string& file : files) inputs.push_back({file, "", ""});
    return inputs;
  }
  const std::vector<std::string> names = output_names(files);
  std::map<std::string, std::string> owners;  // from a name in the output folder to the file that is written there
  for (std::size_t i = 0; i < files.size(); ++i) {
    const std::string stem = (fs::path(out_dir) / names[i]).string();
    const auto [owner, is_new] = owners.emplace(names[i], files[i]);
    if (!is_new) {
      return absl::InvalidArgumentError(
          fmt::format("{} and {} would both be written to {}.pcd: rename one of them", owner->second, files[i], stem));
    }
    inputs.push_back({files[i], stem + ".pcd", stem + ".json"});
    std::error_code error;
    if (fs::equivalent(files[i], inputs.back().cloud_path, error)) {
      return absl::InvalidArgumentError(
          fmt::format("{} would be overwritten by its own output: use another folder for --out-dir", files[i]));
    }
  }
  return inputs;
}

std::optional<DoneBefore> done_before(const BatchInput& input, const std::string& key) {
  std::error_code error;
  if (!fs::is_regular_file(input.cloud_path, error) || !fs::is_regular_file(input.summary_path, error)) {
    return std::nullopt;
  }
  std::ifstream file(input.summary_path);
  const auto summary = Json::parse(file, nullptr, false);
  const Json batch = member(summary, "batch");
  const auto file_name = [](const std::string& path) { return json_text(fs::path(path).filename().string()); };
  const bool is_same = text(member(batch, "key")) == key &&
                       file_name(text(member(batch, "input"))) == file_name(input.path) &&
                       number(member(batch, "input_bytes")) == fs::file_size(input.path, error);
  if (!is_same) return std::nullopt;
  return DoneBefore{number(member(summary, "points")), static_cast<std::uint32_t>(number(member(summary, "segments")))};
}

}  // namespace segserve::segctl
